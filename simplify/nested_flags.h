#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "simplify/split_flags.h"

namespace tintree::simplify {

/// The flags of nested meshes, coarsest first: what a mesh splits, the finer ones do too.
class NestedFlags {
 public:
  NestedFlags(std::int64_t cells, int meshes) {
    for (int i = 0; i < meshes; ++i) flags_.emplace_back(cells);
  }

  /// The coarsest mesh that splits at a point; their number where none does.
  std::size_t first(std::int64_t x, std::int64_t y) const {
    std::size_t mesh = flags_.size();
    while (mesh > 0 && flags_[mesh - 1].get(x, y)) --mesh;
    return mesh;
  }
  bool all(std::int64_t x, std::int64_t y) const { return flags_.front().get(x, y); }
  /// Splits in this mesh and the finer ones; true when it had not been split there.
  bool set(std::size_t mesh, std::int64_t x, std::int64_t y) {
    std::size_t i = mesh;
    while (i < flags_.size() && flags_[i].set(x, y)) ++i;
    return i > mesh;
  }
  std::vector<SplitFlags> take() { return std::move(flags_); }

 private:
  std::vector<SplitFlags> flags_;
};

}  // namespace tintree::simplify
