#include "apps/build/input.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <thread>
#include <utility>

#include <fmt/core.h>

#include "apps/common/whole_file.h"
#include "simplify/picture_layer.h"

namespace tintree::app {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMiB = 1024 * 1024;
/// What a build takes besides the caches of the DEM, and half of it again for every thread.
constexpr std::uint64_t kWorkMiB = 96;
/// What a thread may hold of the DEM's blocks for its tile: a part of that half, spent by the cache, which counts them.
constexpr std::uint64_t kHeldMiB = 8;
/// One part in this many of what is left stays free: allocators never give back all.
constexpr std::uint64_t kSpareShare = 5;
/// GDAL's part of the caches of the DEM is one in this many.
constexpr std::uint64_t kGdalShare = 8;
/// The residual pyramid's is one in this many at most.
constexpr std::uint64_t kPyramidShare = 4;

/// Textures are this large by default, or twice that or four times where the photos are finer.
constexpr int kTextureSize = 256;
constexpr int kMostTextureSize = 1024;

/// Where temporary files go.
std::string scratch_folder(const BuildOptions& options) {
  return options.output.empty() ? fs::temp_directory_path().string() : folder_of(options.output);
}

/// The least usual size whose texels, in a leaf, are hardly larger than the photos' pixels.
int default_texture_size(int tile_cells, double pixel_samples) {
  int size = kTextureSize;
  while (size < kMostTextureSize && simplify::is_finer(pixel_samples, static_cast<double>(tile_cells) / size))
    size *= 2;
  return size;
}

/// The halvings of leaves at which texels are hardly larger than the photos' pixels, or as many as there can be.
int deepest_textures(const codec::TreeLayout& layout, int texture_size, double pixel_samples) {
  const double leaf_texel = static_cast<double>(layout.tile_cells) / texture_size;
  const int most = std::min({cache::kMostTextureDepth, std::countr_zero(static_cast<unsigned>(layout.tile_cells)),
                             (codec::kMaxLevel - layout.leaf_level) / layout.levels_per_doubling});
  int depth = 0;
  while (depth < most && simplify::is_finer(pixel_samples, std::ldexp(leaf_texel, -depth))) ++depth;
  return depth;
}

}  // namespace

int thread_count(const BuildOptions& options) {
  return options.threads > 0 ? options.threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

Expected<MemoryShares> share_memory(const BuildOptions& options, const cache::RasterInfo& info) {
  const int threads = thread_count(options);
  const auto many = static_cast<std::uint64_t>(threads);
  const std::uint64_t work = kWorkMiB + kWorkMiB / 2 * many;
  if (options.memory_mib < work + 64) {
    return fail(ErrorCode::kUsage, fmt::format("{} threads need at least {} MiB", threads, work + 64), "--memory");
  }
  const std::uint64_t free_bytes = (options.memory_mib - work) * kMiB;
  const std::uint64_t cache_bytes = free_bytes - free_bytes / kSpareShare;
  MemoryShares shares;
  shares.pyramid_bytes =
      std::min(simplify::ReferenceSurface::pyramid_bytes(info.columns, info.rows), cache_bytes / kPyramidShare);
  shares.raster_bytes = cache_bytes / kGdalShare;
  shares.blocks_bytes = cache_bytes - shares.raster_bytes - shares.pyramid_bytes + kHeldMiB * kMiB * many;
  return shares;
}

Expected<Input> open_input(const BuildOptions& options, const simplify::ProgressFn& progress) {
  auto source = cache::RasterSource::open(options.dems);
  if (!source) return tl::unexpected(source.error());
  const auto memory = share_memory(options, source->info());
  if (!memory) return tl::unexpected(memory.error());
  const std::string folder = scratch_folder(options);
  Input input{source->info(), nullptr, *memory, folder};
  if (!options.quiet) {
    for (const std::string& w : input.info.warnings) {
      fmt::print(stderr, "tintree-build: {}: warning: {}\n", input.info.path, w);
    }
  }
  cache::StageOptions stage;
  stage.nodata = options.nodata;
  stage.folder = folder;
  stage.raster_cache_bytes = memory->raster_bytes;
  stage.block_cache_bytes = memory->blocks_bytes;
  stage.progress = progress;
  // No other cache is there yet.
  cache::set_raster_cache_bytes((memory->raster_bytes + memory->blocks_bytes) / 2);
  if (auto staged = source->stage(stage); !staged) return tl::unexpected(staged.error());
  cache::set_raster_cache_bytes(source->is_copied() ? 0 : memory->raster_bytes);
  input.blocks = std::make_shared<cache::HeightBlocks>(std::make_shared<cache::RasterSource>(std::move(*source)),
                                                       memory->blocks_bytes);
  return input;
}

Expected<std::optional<cache::OrthoSource>> open_photos(const BuildOptions& options, const cache::RasterInfo& dem,
                                                        const simplify::ProgressFn& progress) {
  if (options.orthos.empty()) return std::nullopt;
  const auto memory = share_memory(options, dem);
  if (!memory) return tl::unexpected(memory.error());
  auto photos = cache::OrthoSource::open(options.orthos, dem);
  if (!photos) return tl::unexpected(photos.error());
  for (const std::string& w : photos->warnings()) {
    if (!options.quiet) fmt::print(stderr, "tintree-build: warning: {}\n", w);
  }
  if (auto staged = photos->stage(scratch_folder(options), memory->raster_bytes, progress); !staged) {
    return tl::unexpected(staged.error());
  }
  cache::set_raster_cache_bytes(memory->raster_bytes);
  return std::optional(std::move(*photos));
}

cache::Manifest describe_tree(const BuildOptions& options, const cache::RasterInfo& info,
                              const std::optional<cache::OrthoSource>& photos) {
  cache::Manifest manifest;
  manifest.method = options.method;
  manifest.effort = options.effort;
  if (options.method == "scalar") manifest.quantizer = options.quantizer.value_or("uniform");
  if (options.method == "wavelet") manifest.criterion = options.criterion.value_or("rms");
  manifest.crs_wkt = info.crs_wkt;
  manifest.geotransform = info.geotransform;
  manifest.geographic = info.geographic;
  manifest.height_unit_m = info.height_unit_m;
  manifest.nodata = options.nodata;
  manifest.inputs = info.inputs;
  codec::TreeLayout& layout = manifest.layout;
  layout.columns = info.columns;
  layout.rows = info.rows;
  layout.tile_cells = options.tile_cells;
  layout.levels_per_doubling = options.levels_per_doubling;
  layout.leaf_level =
      codec::TreeLayout::leaf_level_for(info.columns, info.rows, options.tile_cells, options.levels_per_doubling);
  layout.dx_m = info.dx_m;
  layout.dy_m = info.dy_m;
  layout.axes = info.axes;
  if (photos) {
    manifest.texture_size =
        options.texture_size.value_or(default_texture_size(options.tile_cells, photos->pixel_samples()));
    manifest.texture_depth = std::min(options.texture_depth.value_or(cache::kMostTextureDepth),
                                      deepest_textures(layout, manifest.texture_size, photos->pixel_samples()));
    manifest.texture_codec = options.texture_codec;
    manifest.orthos = photos->inputs();
  }
  manifest.normal_maps = options.normal_maps;
  layout.leaf_error_m = options.error_m.value_or(std::sqrt(info.dx_m * info.dy_m) / 2);
  return manifest;
}

}  // namespace tintree::app
