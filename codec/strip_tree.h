#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/sparse_grid.h"
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
  bool is_split(const SplitPoint& p) const { return numbers_.get(p.x, p.y) != kNoPoint; }
  /// The vertex's height in the tile's height steps, negative where it is missing.
  std::int32_t z(const SplitPoint& p) const { return at(p).z; }
  /// Triangles, holes included.
  std::uint32_t triangles() const { return triangles_; }
  bool holes() const { return holes_; }

 private:
  StripTree(int levels, int fine);

  /// A vertex, or the corner of a hole.
  struct Point {
    std::int32_t z = kMissing;
    std::uint8_t marks = 0;  ///< In which of 8 directions a triangle has its right angle here.
  };
  static constexpr std::int32_t kMissing = -1;

  const Point& at(const SplitPoint& p) const { return points_[static_cast<std::size_t>(numbers_.get(p.x, p.y))]; }
  Point& at_vertex(std::uint32_t v) { return points_[static_cast<std::size_t>(of_vertex_[v])]; }
  bool add(const SplitPoint& p);
  void force(const SplitPoint& p);
  bool place(const TileMesh& mesh);
  bool mark(const TileMesh& mesh, const Triangle& t);
  bool split_false_triangles(std::size_t wanted, bool& changed);

  int levels_;
  int fine_;
  std::int64_t span_;
  PointNumbers numbers_;
  std::vector<Point> points_;
  std::vector<std::int32_t> of_vertex_;  // the point at each of the mesh's vertices
  std::uint32_t triangles_ = 0;
  bool holes_ = false;
};

}  // namespace tintree::codec
