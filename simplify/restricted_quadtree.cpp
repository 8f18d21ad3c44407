#include "simplify/restricted_quadtree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/split_fans.h"
#include "simplify/finish_tile.h"
#include "simplify/split_search.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {

using codec::SplitPoint;

RestrictedQuadtree::RestrictedQuadtree(SurfaceView& view, const LevelGrid& level, std::int64_t column0,
                                       std::int64_t row0)
    : RestrictedQuadtree(view, level, find_splits(view, level, column0, row0), nullptr, column0, row0) {}

RestrictedQuadtree::RestrictedQuadtree(SurfaceView& view, const LevelGrid& level, const SplitFlags& flags,
                                       const RestrictedQuadtree* finer, std::int64_t column0, std::int64_t row0)
    : cells_(level.cells), samples_(level.cells), middles_(level.cells) {
  const std::int64_t ring = kRingSquares * level.square();
  flags.for_each([&](std::int64_t x, std::int64_t y) {
    const SplitPoint p{x - ring, y - ring};
    if (p.x >= 0 && p.y >= 0 && p.x <= cells_ && p.y <= cells_) samples_.set(p.x, p.y);
  });
  const double bound_m =
      tested_bound_m(view.surface(), {column0, row0, column0 + cells_, row0 + cells_}, level.bound_m);
  split_cells(view, level, column0, row0, bound_m);
  merge_squares(view, level, column0, row0, bound_m, finer);
  sample_count_ = samples_.number();
  middle_count_ = middles_.number();
}

std::vector<RestrictedQuadtree> RestrictedQuadtree::nested(SurfaceView& view, const LevelGrid& finest, int count,
                                                           std::int64_t column0, std::int64_t row0) {
  const std::vector<SplitFlags> flags = find_nested_splits(view, finest, count, column0, row0);
  std::vector<RestrictedQuadtree> trees;
  LevelGrid level = finest;
  for (auto f = flags.rbegin(); f != flags.rend(); ++f, level.bound_m *= 2) {
    RestrictedQuadtree tree(view, level, *f, trees.empty() ? nullptr : &trees.back(), column0, row0);
    trees.push_back(std::move(tree));
  }
  std::ranges::reverse(trees);
  return trees;
}

/// Cells that the mesh cuts against the surface's diagonal and has both halves of. find_splits() leaves the other
/// ones only where they stay within the bound.
void RestrictedQuadtree::split_cells(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0,
                                     double bound_m) {
  samples_.for_each([&](std::int64_t x, std::int64_t y) {
    if (((x + y) & 1) == 0 || x == cells_ || y == cells_ || !samples_.get(x + 1, y + 1)) return;
    const double nw = view.sample(column0 + x, row0 + y);
    const double ne = view.sample(column0 + x + 1, row0 + y);
    const double sw = view.sample(column0 + x, row0 + y + 1);
    const double se = view.sample(column0 + x + 1, row0 + y + 1);
    const int missing = std::isnan(nw) + std::isnan(ne) + std::isnan(sw) + std::isnan(se);
    const bool off = missing == 0 && std::abs((level.heights.snapped_m(ne) + level.heights.snapped_m(sw)) / 2 -
                                              (nw + se) / 2) > bound_m;
    if (off || missing == 1) middles_.set(x, y);
  });
}

/// Takes away interior corners of the level's squares, small squares first, whose triangles need not be split: those
/// that a finer mesh can do without, and those whose triangles fit.
void RestrictedQuadtree::merge_squares(SurfaceView& view, const LevelGrid& level, std::int64_t column0,
                                       std::int64_t row0, double bound_m, const RestrictedQuadtree* finer) {
  SurfaceDistance distance(view, column0, row0);
  // In whole samples; a point's children may be middles of cells.
  const auto needed = [&](const SplitPoint& p) {
    return std::ranges::any_of(codec::split_children({2 * p.x, 2 * p.y}),
                               [&](const SplitPoint& child) { return get(child); });
  };
  const auto corner = [&](const SplitPoint& p) {
    const double h = distance.surface().sample(p.x, p.y);
    return Point{static_cast<double>(p.x), static_cast<double>(p.y), std::isnan(h) ? 0 : level.heights.snapped_m(h)};
  };
  const auto fits = [&](const SplitPoint& p) {
    if (finer != nullptr && !finer->samples_.get(p.x, p.y)) return true;
    const SplitPoint apex = codec::split_parents(p)[0];
    const SplitPoint turn{apex.y - p.y, p.x - apex.x};
    const Point a = corner({p.x + turn.x, p.y + turn.y});
    const Point b = corner({p.x - turn.x, p.y - turn.y});
    return std::ranges::all_of(codec::split_parents(p), [&](const SplitPoint& right_angle) {
      return distance.fit_triangle(a, b, corner(right_angle), bound_m) != SurfaceDistance::Fit::kBeyond;
    });
  };
  for (std::int64_t unit = level.square(); unit < cells_ / 2 && !view.interrupted(); unit *= 2) {
    for (const bool centres : {false, true}) {
      for (std::int64_t y = unit; y < cells_; y += unit) {
        for (std::int64_t x = unit; x < cells_; x += unit) {
          const int odd = ((x & unit) != 0) + ((y & unit) != 0);
          const SplitPoint p{x, y};
          if (odd == (centres ? 2 : 1) && samples_.get(x, y) && !needed(p) && fits(p)) samples_.clear(x, y);
        }
      }
    }
  }
}

double quadtree_height_m(SurfaceView& view, std::int64_t column0, std::int64_t row0, const SplitPoint& p) {
  const std::int64_t column = column0 + (p.x >> 1);
  const std::int64_t row = row0 + (p.y >> 1);
  const double height = view.sample(column, row);
  return (p.x & 1) == 0 ? height : (height + view.sample(column + 1, row + 1)) / 2;
}

Expected<codec::TileMesh> quadtree_tile(const RestrictedQuadtree& tree, SurfaceView& view, const HeightLattice& lattice,
                                        int height_unit, std::int64_t column0, std::int64_t row0,
                                        const codec::TileId& id) {
  codec::TileMesh mesh =
      tree.mesh(lattice, [&](const SplitPoint& p) { return quadtree_height_m(view, column0, row0, p); });
  mesh.z_offset *= height_unit;
  for (codec::GridVertex& v : mesh.vertices) v.z *= height_unit;
  // Fans can only touch at holes.
  if (mesh.vertices.size() < tree.vertices()) codec::split_fans(mesh);
  return finish_tile(std::move(mesh), 2 * tree.cells(), 1, id);
}

}  // namespace tintree::simplify
