#include "apps/build/build_tree.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#include <fmt/core.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include "apps/common/progress.h"
#include "apps/common/program.h"
#include "apps/common/stop_deadline.h"
#include "cache/height_blocks.h"
#include "cache/raster_source.h"
#include "cache/tile_store.h"

namespace tintree::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMiB = 1024 * 1024;
/// What a build takes besides the caches of the DEM, per thread and at all.
constexpr std::uint64_t kWorkMiB = 96;
/// GDAL's part of the caches of the DEM is one in this many.
constexpr std::uint64_t kGdalShare = 8;

double seconds_since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

std::string folder_of(const std::string& path) {
  const std::string parent = fs::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}
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
    if (fs::is_directory(path, ec)) return fail(ErrorCode::kIo, "is a directory; name a file", path);
  }
  const std::string folder = folder_of(options.output);
  if (!fs::is_directory(folder, ec)) return fail(ErrorCode::kIo, "no such folder; create it first", folder);
  if (::access(folder.c_str(), W_OK) != 0)
    return fail(ErrorCode::kIo, "the folder may not be written to; check its permissions", folder);
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

Expected<cache::Manifest> plan_tree(const BuildOptions& options, const cache::RasterInfo& info,
                                    const simplify::ReferenceSurface& surface) {
  cache::Manifest manifest;
  manifest.method = options.method;
  manifest.crs_wkt = info.crs_wkt;
  manifest.geotransform = info.geotransform;
  manifest.geographic = info.geographic;
  manifest.height_unit_m = info.height_unit_m;
  manifest.nodata = options.nodata;
  manifest.inputs = info.inputs;
  manifest.samples_digest = surface.digest();
  codec::TreeLayout& layout = manifest.layout;
  layout.columns = info.columns;
  layout.rows = info.rows;
  layout.tile_cells = options.tile_cells;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(info.columns, info.rows, options.tile_cells);
  layout.dx_m = info.dx_m;
  layout.dy_m = info.dy_m;
  layout.axes = info.axes;
  layout.leaf_error_m = options.error_m.value_or(std::sqrt(info.dx_m * info.dy_m) / 2);
  auto steps = simplify::choose_height_steps(surface, layout);
  if (!steps) {
    steps.error().where = info.path;
    return tl::unexpected(steps.error());
  }
  layout.z_step_m = std::move(*steps);
  return manifest;
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

/// Opens the DEM and makes it ready to be read in small windows: from then on GDAL keeps its share of the cache.
Expected<cache::RasterSource> open_dem(const BuildOptions& options, std::uint64_t cache_bytes,
                                       const simplify::ProgressFn& progress) {
  auto source = cache::RasterSource::open(options.dems);
  if (!source) return source;
  const cache::RasterInfo& info = source->info();
  if (!options.quiet) {
    for (const std::string& w : info.warnings) fmt::print(stderr, "tintree-build: {}: warning: {}\n", info.path, w);
  }
  cache::StageOptions stage;
  stage.nodata = options.nodata;
  stage.folder = folder_of(options.output);
  stage.raster_cache_bytes = cache_bytes / kGdalShare;
  stage.block_cache_bytes = cache_bytes - stage.raster_cache_bytes;
  stage.progress = progress;
  // No other cache is there yet.
  cache::set_raster_cache_bytes(cache_bytes / 2);
  if (auto staged = source->stage(stage); !staged) return tl::unexpected(staged.error());
  cache::set_raster_cache_bytes(source->is_copied() ? 0 : stage.raster_cache_bytes);
  return source;
}

/// Says what --nodata fill has left.
void warn_of_holes(const BuildOptions& options, const BuildReport& report, const std::string& path) {
  if (options.quiet || options.nodata == cache::NodataPolicy::kHole || report.valid_samples == report.samples) return;
  fmt::print(stderr, "tintree-build: {}: warning: {} samples stay holes: no height within {} samples of them\n", path,
             report.samples - report.valid_samples, cache::kFillDistance);
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
    level.add(*tile);
    level.error_m = std::max(level.error_m, tile->info.error_m);
    level.rms_m = std::numeric_limits<double>::quiet_NaN();  // the file does not hold what that takes
  }
  return report;
}

/// The DEM, and who looks at it.
struct Input {
  cache::RasterInfo info;
  std::shared_ptr<cache::HeightBlocks> blocks;
};

Expected<Input> open_input(const BuildOptions& options, int threads, const simplify::ProgressFn& progress) {
  const std::uint64_t work = kWorkMiB + kWorkMiB / 2 * static_cast<std::uint64_t>(threads);
  if (options.memory_mib < work + 64) {
    return fail(ErrorCode::kUsage, fmt::format("{} threads need at least {} MiB", threads, work + 64), "--memory");
  }
  const std::uint64_t cache_bytes = (options.memory_mib - work) * kMiB;
  auto source = open_dem(options, cache_bytes, progress);
  if (!source) return tl::unexpected(source.error());
  Input input{source->info(), nullptr};
  input.blocks = std::make_shared<cache::HeightBlocks>(std::make_shared<cache::RasterSource>(std::move(*source)),
                                                       cache_bytes - cache_bytes / kGdalShare);
  return input;
}

/// Makes, measures and finishes; fills in the report.
Expected<void> make_tree(const simplify::ReferenceSurface& surface, cache::TileWriter& writer,
                         const simplify::ProgressFn& progress, BuildReport& report) {
  auto mark = Clock::now();
  auto levels = simplify::make_tiles(surface, report.manifest, writer, progress, stop_flag());
  if (!levels) return tl::unexpected(levels.error());
  report.make_seconds = seconds_since(mark);
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
  auto input = open_input(options, threads, progress);
  if (!input) return tl::unexpected(input.error());
  auto surface = simplify::ReferenceSurface::scan(
      input->blocks, [&](std::uint64_t done, std::uint64_t total) { return progress("reading blocks", done, total); });
  if (!surface) return tl::unexpected(surface.error());
  const double read_seconds = seconds_since(begun);
  if ((*surface)->valid_samples() == 0)
    return fail(ErrorCode::kBadData, "holds no heights: every sample is nodata", input->info.path);
  if (!(*surface)->has_surface())
    return fail(ErrorCode::kBadData, "holds no surface: nowhere do three samples of a cell have heights",
                input->info.path);

  auto manifest = plan_tree(options, input->info, **surface);
  if (!manifest) return tl::unexpected(manifest.error());
  BuildReport report;
  if (*start == Start::kFinished) {
    auto finished = report_finished(options, *manifest);
    if (!finished) return finished;
    report = std::move(*finished);
  } else {
    auto writer = *start == Start::kUnfinished ? cache::TileWriter::resume(options.output, *manifest)
                                               : cache::TileWriter::create(options.output, *manifest);
    if (!writer) return tl::unexpected(writer.error());
    report.manifest = std::move(*manifest);
    if (auto made = make_tree(**surface, *writer, progress, report); !made) {
      return tl::unexpected(with_remedy(made.error(), options));
    }
  }
  report.threads = threads;
  report.read_seconds = read_seconds;
  report.samples = static_cast<std::uint64_t>(input->info.columns) * static_cast<std::uint64_t>(input->info.rows);
  report.valid_samples = (*surface)->valid_samples();
  report.file_bytes = fs::file_size(options.output);
  warn_of_holes(options, report, input->info.path);
  report.seconds = seconds_since(begun);
  return report;
}

}  // namespace

Expected<BuildReport> build_tree(const BuildOptions& options) {
  const int threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const Error stopped = with_remedy({ErrorCode::kStopped, {}, {}}, options);
  const StopDeadline deadline("tintree-build", stopped);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  auto report = arena.execute([&] { return build_in_arena(options, threads); });
  if (!report && report.error().code == ErrorCode::kStopped) return tl::unexpected(stopped);
  return report;
}

}  // namespace tintree::app
