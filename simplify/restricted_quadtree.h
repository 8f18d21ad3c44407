#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/error.h"
#include "codec/split_hierarchy.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"
#include "simplify/level_grid.h"
#include "simplify/reference_surface.h"
#include "simplify/split_flags.h"

namespace tintree::simplify {

/// A tile's restricted quadtree mesh (Dick et al. 2009, section 4): four right triangles round the tile's centre, each
/// bisected at the middle of its longest side where it does not stay within the bound of the DEM's surface, and where
/// a neighbour's split asks for it. Its vertices are samples at snapped heights, and middles of cells: a cell that the
/// mesh would cut against the surface's own diagonal by more than the bound is split once more, at its middle, where
/// the surface's diagonal runs; so is one of whose four samples one is missing. With that the mesh can follow any
/// surface, holes and the raster's edge: triangles with a missing corner are not there, and what is there
/// covers exactly the surface.
///
/// Points are given in half samples from the tile's north-west sample.
///
/// Two tiles at a side have the same vertices on it: every point of the level's squares (LevelGrid::square) on it, and
/// those between that find_splits() names. Inside the tile, squares are merged as far as the bound allows.
class RestrictedQuadtree {
 public:
  /// Of the tile whose north-west sample is (column0, row0), within level.bound_m everywhere at heights snapped to
  /// level.heights, and half of that along its sides. To be thrown away when the view is interrupted afterwards.
  /// Cost: that of find_splits(), and as much again where the mesh is fine.
  RestrictedQuadtree(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0);

  /// Nested ones, the coarsest first, whose bounds are those of `finest` times 1, 2, 4, ...: the vertices of each are
  /// among those of the next. Cost: little more than that of the finest alone.
  static std::vector<RestrictedQuadtree> nested(SurfaceView& view, const LevelGrid& finest, int count,
                                                std::int64_t column0, std::int64_t row0);

  std::int64_t cells() const { return cells_; }

  /// Whether the triangles that meet at a point exist: it is a vertex (of a hole, if its height is missing).
  bool get(const codec::SplitPoint& p) const {
    if ((p.x & p.y & 1) != 0) return middles_.get(p.x >> 1, p.y >> 1);
    return ((p.x | p.y) & 1) == 0 && samples_.get(p.x >> 1, p.y >> 1);
  }

  /// Vertices, those of holes included. They are numbered from 0.
  std::size_t vertices() const { return static_cast<std::size_t>(sample_count_ + middle_count_); }
  /// A vertex's number.
  std::size_t rank(const codec::SplitPoint& p) const {
    if ((p.x & 1) != 0) return static_cast<std::size_t>(sample_count_ + middles_.rank(p.x >> 1, p.y >> 1));
    return static_cast<std::size_t>(samples_.rank(p.x >> 1, p.y >> 1));
  }

  /// Calls `visit(point)` for every vertex, those of holes included.
  template <typename Visit>
  void for_each_vertex(const Visit& visit) const {
    samples_.for_each([&](std::int64_t x, std::int64_t y) { visit(codec::SplitPoint{2 * x, 2 * y}); });
    middles_.for_each([&](std::int64_t x, std::int64_t y) { visit(codec::SplitPoint{2 * x + 1, 2 * y + 1}); });
  }

  /// Calls `visit(a, b, c)` for every triangle, those of holes included: its longest side from a to b, its right
  /// angle at c, counter-clockwise seen from above.
  template <typename Visit>
  void for_each_triangle(const Visit& visit) const {
    const std::int64_t n = 2 * cells_;
    const auto corner = [n](std::int32_t k) { return codec::SplitPoint{(k & 1) * n, (k >> 1) * n}; };
    const auto split = [this](const codec::SplitPoint& a, const codec::SplitPoint& b, const codec::SplitPoint&) {
      const codec::SplitPoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
      return get(middle) ? std::optional(middle) : std::nullopt;
    };
    for (const auto& [a, b] : codec::kSquareSides)
      codec::bisect(corner(a), corner(b), codec::SplitPoint{cells_, cells_}, split, visit);
  }

  /// The mesh with heights that `height_m(point)` gives, NaN where there is none; on half samples, z_offset being
  /// that of the first vertex (see finish_tile()). Beside holes several fans may share a vertex (codec::split_fans).
  template <typename HeightAt>
  codec::TileMesh mesh(const HeightLattice& lattice, const HeightAt& height_m) const;

 private:
  /// From find_splits()' flags; `finer` may be null.
  RestrictedQuadtree(SurfaceView& view, const LevelGrid& level, const SplitFlags& flags,
                     const RestrictedQuadtree* finer, std::int64_t column0, std::int64_t row0);

  void split_cells(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0, double bound_m);
  void merge_squares(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0, double bound_m,
                     const RestrictedQuadtree* finer);

  std::int64_t cells_;
  SplitFlags samples_;
  SplitFlags middles_;  // of the cells with this north-west sample
  std::int32_t sample_count_ = 0;
  std::int32_t middle_count_ = 0;
};

/// The surface's height at a point of a tile's mesh, in half samples from sample (column0, row0): a sample or the
/// middle of a cell. NaN where there is no surface next to it.
double quadtree_height_m(SurfaceView& view, std::int64_t column0, std::int64_t row0, const codec::SplitPoint& p);

/// The tile's mesh at the surface's own heights, ready to be stored; a step of `lattice` is so many of the level's.
/// Fails as finish_tile() does.
Expected<codec::TileMesh> quadtree_tile(const RestrictedQuadtree& tree, SurfaceView& view, const HeightLattice& lattice,
                                        int height_unit, std::int64_t column0, std::int64_t row0,
                                        const codec::TileId& id);

template <typename HeightAt>
codec::TileMesh RestrictedQuadtree::mesh(const HeightLattice& lattice, const HeightAt& height_m) const {
  constexpr std::uint32_t kUnknown = UINT32_MAX;
  constexpr std::uint32_t kMissing = kUnknown - 1;
  codec::TileMesh out;
  HeightLattice heights = lattice;
  std::vector<std::uint32_t> index(vertices(), kUnknown);
  const auto exists = [&](const codec::SplitPoint& p) {
    std::uint32_t& i = index[rank(p)];
    if (i == kUnknown && std::isnan(height_m(p))) i = kMissing;
    return i != kMissing;
  };
  const auto vertex = [&](const codec::SplitPoint& p) {
    std::uint32_t& i = index[rank(p)];
    if (i != kUnknown) return i;
    const double h = height_m(p);
    if (out.vertices.empty()) out.z_offset = heights.origin = heights.address(h);
    i = static_cast<std::uint32_t>(out.vertices.size());
    out.vertices.push_back({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), heights.snap(h)});
    return i;
  };
  for_each_triangle([&](const codec::SplitPoint& a, const codec::SplitPoint& b, const codec::SplitPoint& c) {
    if (exists(a) && exists(b) && exists(c)) out.triangles.push_back({vertex(a), vertex(b), vertex(c)});
  });
  return out;
}

}  // namespace tintree::simplify
