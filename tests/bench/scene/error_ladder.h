#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "tests/bench/scene/ground_blocks.h"

namespace tintree::bench {

/// How many triangles a mesh needs at each place for each error: meshes of the same ground at a ladder of errors.
class ErrorLadder {
 public:
  /// The rung of meshes within `error_m`. All rungs must have the same blocks.
  void add(double error_m, GroundBlocks blocks);

  /// Triangles on a block within `error_m`: logarithms interpolated between the rungs; below the finest rung its own,
  /// beyond the coarsest falling on as the total does between the last two.
  double triangles(std::size_t block, double error_m) const;

  double finest_m() const { return rungs_.begin()->first; }
  double coarsest_m() const { return rungs_.rbegin()->first; }
  /// The ground as the finest rung has it.
  const GroundBlocks& ground() const { return rungs_.begin()->second; }

 private:
  double beyond(std::size_t block, double error_m) const;

  std::map<double, GroundBlocks> rungs_;
};

}  // namespace tintree::bench
