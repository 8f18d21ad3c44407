#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cache/manifest.h"
#include "codec/error.h"
#include "simplify/picture_pyramid.h"
#include "simplify/tree_builder.h"

namespace tintree::app {

/// The command line of tintree-build.
struct BuildOptions {
  std::vector<std::string> dems;  ///< Where they overlap, the later one counts.
  std::string output;
  std::optional<double> error_m;  ///< Bound of the leaves; default half the sample spacing.
  std::string method = "tin";
  std::string effort = "fast";
  std::optional<std::string> quantizer;  ///< Of method scalar: uniform, the default there, or lloyd-max.
  std::optional<std::string> criterion;  ///< Of method wavelet: rms, the default there, or max.
  int tile_cells = 256;
  int levels_per_doubling = 1;       ///< 1, or 2 for levels whose errors are a factor of √2 apart.
  std::vector<std::string> orthos;   ///< Photos to drape over the terrain; where they overlap, the later one counts.
  std::optional<int> texture_size;   ///< Texels along a tile's side; default 256, and more where the photos are finer.
  std::optional<int> texture_depth;  ///< The most halvings of leaves for finer textures.
  std::string texture_codec = "bc1";
  bool normal_maps = false;
  int threads = 0;  ///< 0: all cores.
  std::uint64_t memory_mib = 1024;
  cache::NodataPolicy nodata = cache::NodataPolicy::kHole;
  bool resume = false;
  bool overwrite = false;
  bool plan = false;
  std::string json;  ///< Empty: none.
  bool quiet = false;
};

/// What a build did.
struct BuildReport {
  cache::Manifest manifest;
  std::vector<simplify::LevelSummary> levels;
  std::uint64_t samples = 0;  ///< Of the raster, nodata too.
  std::uint64_t valid_samples = 0;
  std::uint64_t file_bytes = 0;
  double seconds = 0;
  double read_seconds = 0;
  double make_seconds = 0;
  double measure_seconds = 0;
  double picture_seconds = 0;         ///< Textures and normal maps.
  simplify::PictureSummary textures;  ///< Nothing without --ortho.
  simplify::PictureSummary normals;   ///< Nothing without --normal-maps.
  int threads = 0;
};

/// Builds the tree. Warnings go to standard error unless quiet.
Expected<BuildReport> build_tree(const BuildOptions& options);

}  // namespace tintree::app
