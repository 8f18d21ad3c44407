#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/split_flags.h"
#include "codec/split_hierarchy.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// The restricted quadtree mesh that a tile's triangles are part of, found again from the triangles alone: the coarsest
/// one that has all of them among its own. The others among its own are holes; each of them has a corner where the
/// tile has no vertex.
class StripTree {
 public:
  /// None when the triangles are not part of a restricted quadtree mesh over the square of 2^levels steps that begins
  /// at address (0, 0), a step being 2^-fine address steps.
  static std::optional<StripTree> find(const TileMesh& mesh, int levels, int fine);

  int levels() const { return levels_; }
  int fine() const { return fine_; }
  bool is_split(const SplitPoint& p) const { return flags_.get(p.x, p.y); }
  /// The vertex's height in the tile's height steps, negative where it is missing.
  std::int32_t z(const SplitPoint& p) const { return z_[static_cast<std::size_t>(flags_.rank(p.x, p.y))]; }
  /// Triangles, holes included.
  std::uint32_t triangles() const { return triangles_; }
  bool holes() const { return holes_; }

 private:
  StripTree(int levels, int fine);

  void force(const SplitPoint& p);
  bool place(const TileMesh& mesh);
  bool mark(const TileMesh& mesh, const Triangle& t);
  bool split_false_triangles(std::size_t wanted, bool& changed);

  int levels_;
  int fine_;
  std::int64_t span_;
  SplitFlags flags_;
  std::vector<std::int32_t> z_;
  std::vector<std::uint8_t> marks_;  // of a vertex: in which of 8 directions a triangle has its right angle here
  std::uint32_t triangles_ = 0;
  bool holes_ = false;
};

}  // namespace tintree::codec
