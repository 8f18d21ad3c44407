#pragma once

#include <cstdint>
#include <vector>

#include "apps/build/build_tree.h"
#include "apps/build/plan_pictures.h"
#include "codec/error.h"
#include "simplify/tree_builder.h"

namespace tintree::app {

/// What a build is expected to do. Figures are estimates, except for the counts of tiles.
struct TreePlan {
  struct Level {
    simplify::LevelSummary estimate;  ///< `tiles` counts those over nodata alone too; no errors.
    std::uint64_t sampled = 0;        ///< Tiles that were made for it; 0: judged by the levels below.
  };
  std::vector<Level> levels;
  simplify::LevelSummary total;
  std::uint64_t samples = 0;
  std::uint64_t bytes = 0;  ///< Of the file.
  double seconds = 0;       ///< Of the build, all that follows together.
  double read_seconds = 0;
  double make_seconds = 0;
  double measure_seconds = 0;
  double picture_seconds = 0;
  PicturePlan textures;   ///< Nothing without --ortho.
  int texture_depth = 0;  ///< How often leaves are halved for them.
  PicturePlan normals;    ///< Nothing without --normal-maps.
  std::uint64_t peak_rss_bytes = 0;
  int threads = 0;
  double plan_seconds = 0;  ///< What the plan itself took.
};

/// Judges a build by a sample of its tiles, made in memory; writes nothing. Warnings go to standard error unless
/// quiet.
Expected<TreePlan> plan_tree(const BuildOptions& options);

}  // namespace tintree::app
