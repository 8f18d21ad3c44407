#include "apps/build/build_tree.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

#include <fmt/core.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include "apps/common/progress.h"
#include "apps/common/program.h"
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

/// Refuses before any work what would fail after it.
Expected<void> check_output(const BuildOptions& options) {
  std::error_code ec;
  if (fs::is_directory(options.output, ec)) return fail(ErrorCode::kIo, "is a directory; name a file", options.output);
  if (fs::exists(options.output, ec) && !options.overwrite) {
    return fail(ErrorCode::kIo, "exists already; remove it or use --overwrite", options.output);
  }
  const std::string building = cache::TileWriter::building_path(options.output);
  if (fs::exists(building, ec) && !options.resume && !options.overwrite) {
    return fail(ErrorCode::kIo, "an unfinished build is there; go on with it by --resume or discard it by --overwrite",
                building);
  }
  const std::string folder = folder_of(options.output);
  if (!fs::is_directory(folder, ec)) return fail(ErrorCode::kIo, "no such folder; create it first", folder);
  if (::access(folder.c_str(), W_OK) != 0)
    return fail(ErrorCode::kIo, "the folder may not be written to; check its permissions", folder);
  return {};
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

Expected<cache::TileWriter> open_writer(const BuildOptions& options, const cache::Manifest& manifest) {
  return options.resume ? cache::TileWriter::resume(options.output, manifest)
                        : cache::TileWriter::create(options.output, manifest);
}

Error with_remedy(Error error, const BuildOptions& options) {
  if (error.code == ErrorCode::kStopped) error.message += "; go on with the same command and --resume";
  if (error.code == ErrorCode::kStopped && error.where.empty()) error.where = options.output;
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

Expected<BuildReport> build_in_arena(const BuildOptions& options, int threads) {
  const auto begun = Clock::now();
  stop_requested();
  if (auto free = check_output(options); !free) return tl::unexpected(free.error());
  BuildReport report;
  report.threads = threads;

  const std::uint64_t work = kWorkMiB + kWorkMiB / 2 * static_cast<std::uint64_t>(report.threads);
  if (options.memory_mib < work + 64) {
    return fail(ErrorCode::kUsage, fmt::format("{} threads need at least {} MiB", report.threads, work + 64),
                "--memory");
  }
  const std::uint64_t cache_bytes = (options.memory_mib - work) * kMiB;
  Progress line(options.quiet);
  const auto progress = [&](const std::string& step, std::uint64_t done, std::uint64_t total) {
    line.report(step, done, total);
    return !stop_requested();
  };
  auto source = open_dem(options, cache_bytes, progress);
  if (!source) return tl::unexpected(source.error());
  const cache::RasterInfo info = source->info();
  auto blocks = std::make_shared<cache::HeightBlocks>(std::make_shared<cache::RasterSource>(std::move(*source)),
                                                      cache_bytes - cache_bytes / kGdalShare);
  auto surface = simplify::ReferenceSurface::scan(
      blocks, [&](std::uint64_t done, std::uint64_t total) { return progress("reading blocks", done, total); });
  if (!surface) return tl::unexpected(surface.error());
  report.read_seconds = seconds_since(begun);
  if ((*surface)->valid_samples() == 0)
    return fail(ErrorCode::kBadData, "holds no heights: every sample is nodata", info.path);
  if (!(*surface)->has_surface())
    return fail(ErrorCode::kBadData, "holds no surface: nowhere do three samples of a cell have heights", info.path);

  auto manifest = plan_tree(options, info, **surface);
  if (!manifest) return tl::unexpected(manifest.error());
  auto writer = open_writer(options, *manifest);
  if (!writer) return tl::unexpected(writer.error());
  auto mark = Clock::now();
  auto levels = simplify::make_tiles(**surface, *manifest, *writer, progress);
  if (!levels) return tl::unexpected(with_remedy(levels.error(), options));
  report.make_seconds = seconds_since(mark);
  mark = Clock::now();
  if (auto measured = simplify::measure_tiles(**surface, *manifest, *writer, *levels, progress); !measured) {
    return tl::unexpected(with_remedy(measured.error(), options));
  }
  report.measure_seconds = seconds_since(mark);
  line.close();
  auto digest = writer->finish();
  if (!digest) return tl::unexpected(digest.error());

  report.manifest = std::move(*manifest);
  report.manifest.digest = *digest;
  report.levels = std::move(*levels);
  report.samples = static_cast<std::uint64_t>(info.columns) * static_cast<std::uint64_t>(info.rows);
  report.valid_samples = (*surface)->valid_samples();
  report.file_bytes = fs::file_size(options.output);
  warn_of_holes(options, report, info.path);
  report.seconds = seconds_since(begun);
  return report;
}

}  // namespace

Expected<BuildReport> build_tree(const BuildOptions& options) {
  const int threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return build_in_arena(options, threads); });
}

}  // namespace tintree::app
