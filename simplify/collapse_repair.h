#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "simplify/half_edge_mesh.h"
#include "simplify/star_fit.h"

namespace tintree::simplify {

/// Makes room for a collapse that breaks the bound by a little: the merged vertex and its neighbours are moved in
/// turn, each so that the largest error of its own star falls, until all keep the bound. Not thread-safe; reuses its
/// memory.
class CollapseRepair {
 public:
  /// `gone` and `kept` are the free ends of an edge that satisfies the link condition; `ring` surrounds the merged
  /// vertex, whose place to begin with is `merged`. On success the neighbours have moved, moved() names them, and
  /// `merged` is where the merged vertex has to go; otherwise nothing has changed.
  bool run(HalfEdgeMesh& mesh, StarFit& fit, std::int32_t gone, std::int32_t kept, const Ring& ring,
           LatticeVertex& merged);
  std::span<const std::int32_t> moved() const { return moved_; }

 private:
  struct Change {
    std::int32_t vertex;
    LatticeVertex before;
  };

  void put(std::int32_t vertex, const LatticeVertex& place);
  bool lower(LatticeVertex& place, const Ring& ring, int& share, int enough);
  bool try_lower(LatticeVertex& place, const LatticeVertex& there, const Ring& ring, int& share, int enough);
  void gather(std::int32_t vertex);
  bool search(const Ring& ring, LatticeVertex& merged);

  HalfEdgeMesh* mesh_ = nullptr;
  StarFit* fit_ = nullptr;
  std::int32_t gone_ = kNone;
  std::int32_t kept_ = kNone;
  Ring ring_;  // around a neighbour, as if the edge had collapsed
  std::vector<Change> journal_;
  std::vector<std::int32_t> moved_;
};

}  // namespace tintree::simplify
