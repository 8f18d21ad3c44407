#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "apps/build/build_tree.h"
#include "cache/height_blocks.h"
#include "cache/manifest.h"
#include "cache/ortho_source.h"
#include "cache/raster_source.h"
#include "codec/error.h"
#include "simplify/tree_builder.h"

namespace tintree::app {

/// Threads that a build with these options uses.
int thread_count(const BuildOptions& options);

/// How a build shares its memory.
struct MemoryShares {
  std::uint64_t raster_bytes = 0;   ///< GDAL's cache, once the DEM is staged.
  std::uint64_t blocks_bytes = 0;   ///< The cache of height blocks.
  std::uint64_t pyramid_bytes = 0;  ///< The residual pyramid; beyond, it is paged.
};
/// For a DEM of so many samples. kUsage when --memory is too little for the threads.
Expected<MemoryShares> share_memory(const BuildOptions& options, const cache::RasterInfo& info);

/// The DEM and the cache over it.
struct Input {
  cache::RasterInfo info;
  std::shared_ptr<cache::HeightBlocks> blocks;
  MemoryShares memory;
  std::string scratch_folder;  ///< For temporary files.
};
/// Opens the DEM, makes it ready to be read in small windows, and prints its warnings to standard error, unless quiet.
/// Temporary files lie beside the output or, where there is none, in the folder for temporary files.
Expected<Input> open_input(const BuildOptions& options, const simplify::ProgressFn& progress);

/// The photos, ready to be read in small windows, or none where none are asked for. Prints their warnings.
Expected<std::optional<cache::OrthoSource>> open_photos(const BuildOptions& options, const cache::RasterInfo& dem,
                                                        const simplify::ProgressFn& progress);

/// The manifest of the tree that the options ask for, without the samples' digest and the height steps.
cache::Manifest describe_tree(const BuildOptions& options, const cache::RasterInfo& info,
                              const std::optional<cache::OrthoSource>& photos);

}  // namespace tintree::app
