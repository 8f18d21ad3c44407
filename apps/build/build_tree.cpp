#include "apps/build/build_tree.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/core.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "apps/build/input.h"
#include "apps/common/progress.h"
#include "apps/common/program.h"
#include "apps/common/stop_deadline.h"
#include "apps/common/whole_file.h"
#include "cache/tile_store.h"

namespace tintree::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

/// What there is to begin with.
enum class Start {
  kNew,         ///< Nothing that counts.
  kUnfinished,  ///< A build to go on with.
  kFinished,    ///< --resume finds the tree finished: a build may be ended just after that.
};

/// Refuses before any work what would fail after it.
Expected<Start> check_output(const BuildOptions& options) {
  std::error_code ec;
  const std::string building = cache::TileWriter::building_path(options.output);
  for (const std::string& path : {options.output, building}) {
    for (const auto* inputs : {&options.dems, &options.orthos}) {
      if (auto writable = check_output_file(path, *inputs); !writable) return tl::unexpected(writable.error());
    }
  }
  if (options.overwrite) return Start::kNew;
  // An unfinished build beside a tree was begun to overwrite it.
  if (fs::exists(building, ec)) {
    if (options.resume) return Start::kUnfinished;
    return fail(ErrorCode::kIo, "an unfinished build is there; go on with it by --resume or discard it by --overwrite",
                building);
  }
  if (fs::exists(options.output, ec)) {
    if (options.resume) return Start::kFinished;
    return fail(ErrorCode::kIo, "exists already; remove it or use --overwrite", options.output);
  }
  if (options.resume && !options.quiet) {
    fmt::print(stderr, "tintree-build: {}: nothing to resume: begins at the beginning\n", options.output);
  }
  return Start::kNew;
}

Error with_remedy(Error error, const BuildOptions& options) {
  const std::string resume = options.overwrite ? "--resume instead of --overwrite" : "--resume";
  if (error.code == ErrorCode::kStopped) {
    return {error.code, "stopped; what is finished is kept; go on with the same command and " + resume, options.output};
  }
  // The store's messages say it themselves.
  if (error.code == ErrorCode::kIo && error.message.find("--resume") == std::string::npos) {
    error.message += "; what is finished is kept; then go on with the same command and " + resume;
  }
  return error;
}

/// Says what --nodata fill has left.
void warn_of_holes(const BuildOptions& options, const BuildReport& report, const std::string& path) {
  if (options.quiet || options.nodata == cache::NodataPolicy::kHole || report.valid_samples == report.samples) return;
  fmt::print(stderr, "tintree-build: {}: warning: {} samples stay holes: no height within {} samples of them\n", path,
             report.samples - report.valid_samples, cache::kFillDistance);
}

/// Says which strips fall back to meshes when they are drawn.
void warn_of_meshes(const BuildOptions& options, const BuildReport& report) {
  std::uint64_t tiles = 0;
  std::uint64_t meshes = 0;
  for (const simplify::LevelSummary& level : report.levels) {
    tiles += level.tiles;
    meshes += level.drawn_as_meshes;
  }
  if (options.quiet || meshes == 0) return;
  fmt::print(stderr,
             "tintree-build: {}: warning: {} of {} tiles are too tall or too fine to be unpacked by a graphics card, "
             "and are drawn as meshes; a smaller --tile or a larger --error makes them fewer\n",
             options.output, meshes, tiles);
}

/// The report of a tree that was finished before; kUsage when it is another one than the manifest's.
Expected<BuildReport> report_finished(const BuildOptions& options, const cache::Manifest& manifest) {
  auto store = cache::TileStore::open(options.output);
  if (!store) return tl::unexpected(store.error());
  if (const std::string difference = store->manifest().difference(manifest); !difference.empty()) {
    return fail(ErrorCode::kUsage,
                "a finished tree is there that differs in " + difference + "; use --overwrite to replace it",
                options.output);
  }
  BuildReport report;
  report.manifest = store->manifest();
  report.levels = simplify::make_levels(report.manifest.layout);
  for (const cache::TileNode& node : store->bounds().nodes()) {
    auto tile = store->read(node.id);
    if (!tile) return tl::unexpected(tile.error());
    simplify::LevelSummary& level = report.levels[static_cast<std::size_t>(node.id.level)];
    level.add(*tile, report.manifest.method);
    level.error_m = std::max(level.error_m, tile->info.error_m);
    level.rms_m = std::numeric_limits<double>::quiet_NaN();  // the file does not hold what that takes
  }
  for (const auto& [kind, summary] : {std::pair{cache::PictureKind::kTexture, &report.textures},
                                      std::pair{cache::PictureKind::kNormal, &report.normals}}) {
    const auto keys = store->picture_keys(kind);
    if (!keys) return tl::unexpected(keys.error());
    const auto bytes = store->picture_bytes(kind);
    if (!bytes) return tl::unexpected(bytes.error());
    summary->pictures = keys->size();
    summary->bytes = *bytes;
  }
  return report;
}

/// Makes textures and normal maps, as the manifest says; fills in the report.
Expected<void> make_all_pictures(const simplify::ReferenceSurface& surface,
                                 const std::optional<cache::OrthoSource>& photos, cache::TileWriter& writer,
                                 const simplify::ProgressFn& progress, BuildReport& report) {
  const auto mark = Clock::now();
  const cache::Manifest& manifest = report.manifest;
  if (photos) {
    const auto make_layer = [&] { return simplify::make_texture_layer(manifest, *photos); };
    auto made =
        simplify::make_pictures(cache::PictureKind::kTexture, make_layer, manifest, writer, progress, stop_flag());
    if (auto same = photos->check_unchanged(); !same) return same;
    if (!made) return tl::unexpected(made.error());
    report.textures = *made;
  }
  if (manifest.normal_maps) {
    const auto make_layer = [&] { return simplify::make_normal_layer(manifest, surface, stop_flag()); };
    auto made =
        simplify::make_pictures(cache::PictureKind::kNormal, make_layer, manifest, writer, progress, stop_flag());
    if (!made) return tl::unexpected(made.error());
    report.normals = *made;
  }
  report.picture_seconds = seconds_since(mark);
  return {};
}

/// Makes, measures and finishes; fills in the report.
Expected<void> make_tree(const simplify::ReferenceSurface& surface, const std::optional<cache::OrthoSource>& photos,
                         cache::TileWriter& writer, const simplify::ProgressFn& progress, BuildReport& report) {
  auto mark = Clock::now();
  auto levels = simplify::make_tiles(surface, report.manifest, writer, progress, stop_flag());
  if (!levels) return tl::unexpected(levels.error());
  report.make_seconds = seconds_since(mark);
  if (auto pictures = make_all_pictures(surface, photos, writer, progress, report); !pictures) return pictures;
  mark = Clock::now();
  auto done = simplify::measure_tiles(surface, report.manifest, writer, *levels, progress);
  // Measuring reads the file once more: a change explains a failure, and makes a success worthless.
  if (auto same = surface.blocks().source().check_unchanged(); !same) return same;
  if (!done) return done;
  report.measure_seconds = seconds_since(mark);
  auto digest = writer.finish(stop_flag());
  if (!digest) return tl::unexpected(digest.error());
  report.manifest.digest = *digest;
  report.levels = std::move(*levels);
  return {};
}

Expected<BuildReport> build_in_arena(const BuildOptions& options, int threads) {
  const auto begun = Clock::now();
  auto start = check_output(options);
  if (!start) return tl::unexpected(start.error());
  Progress line(options.quiet);
  const auto progress = [&](const std::string& step, std::uint64_t done, std::uint64_t total) {
    line.report(step, done, total);
    return !stop_requested();
  };
  auto input = open_input(options, progress);
  if (!input) return tl::unexpected(input.error());
  auto surface = simplify::ReferenceSurface::scan(
      input->blocks, [&](std::uint64_t done, std::uint64_t total) { return progress("reading blocks", done, total); },
      {input->memory.pyramid_bytes, input->scratch_folder});
  if (!surface) return tl::unexpected(surface.error());
  const double read_seconds = seconds_since(begun);
  if ((*surface)->valid_samples() == 0)
    return fail(ErrorCode::kBadData, "holds no heights: every sample is nodata", input->info.path);
  if (!(*surface)->has_surface())
    return fail(ErrorCode::kBadData, "holds no surface: nowhere do three samples of a cell have heights",
                input->info.path);

  auto photos = open_photos(options, input->info, progress);
  if (!photos) return tl::unexpected(photos.error());
  cache::Manifest manifest = describe_tree(options, input->info, *photos);
  manifest.samples_digest = (*surface)->digest();
  auto steps = simplify::choose_height_steps(**surface, manifest.layout);
  if (!steps) {
    steps.error().where = input->info.path;
    return tl::unexpected(steps.error());
  }
  manifest.layout.z_step_m = std::move(*steps);
  BuildReport report;
  if (*start == Start::kFinished) {
    auto finished = report_finished(options, manifest);
    if (!finished) return finished;
    report = std::move(*finished);
  } else {
    auto writer = *start == Start::kUnfinished ? cache::TileWriter::resume(options.output, manifest)
                                               : cache::TileWriter::create(options.output, manifest);
    if (!writer) return tl::unexpected(writer.error());
    report.manifest = std::move(manifest);
    if (auto made = make_tree(**surface, *photos, *writer, progress, report); !made) {
      return tl::unexpected(with_remedy(made.error(), options));
    }
  }
  report.threads = threads;
  report.read_seconds = read_seconds;
  report.samples = static_cast<std::uint64_t>(input->info.columns) * static_cast<std::uint64_t>(input->info.rows);
  report.valid_samples = (*surface)->valid_samples();
  report.file_bytes = fs::file_size(options.output);
  warn_of_holes(options, report, input->info.path);
  warn_of_meshes(options, report);
  report.seconds = seconds_since(begun);
  return report;
}

}  // namespace

Expected<BuildReport> build_tree(const BuildOptions& options) {
  const int threads = thread_count(options);
  const Error stopped = with_remedy({ErrorCode::kStopped, {}, {}}, options);
  const StopDeadline deadline("tintree-build", stopped);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  auto report = arena.execute([&] { return build_in_arena(options, threads); });
  if (!report && report.error().code == ErrorCode::kStopped) return tl::unexpected(stopped);
  return report;
}

}  // namespace tintree::app
