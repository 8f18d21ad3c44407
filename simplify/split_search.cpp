#include "simplify/split_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "codec/split_hierarchy.h"
#include "simplify/line_samples.h"
#include "simplify/nested_flags.h"
#include "simplify/square_samples.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

/// Searches for several nested meshes at once. A triangle that fits the bound of one fits those of all coarser ones: so
/// the finest mesh's search is the whole search, and only what it splits is tested again, against the next bound,
/// until it fits. Points are classified by their coordinates in the window (codec::SplitPoint).
class SplitSearch {
 public:
  SplitSearch(SurfaceView& view, const LevelGrid& level, int meshes, std::int64_t column0, std::int64_t row0)
      : view_(&view),
        level_(level),
        square_(level.square()),
        ring_(kRingSquares * square_),
        span_(level.cells + 2 * ring_),
        column0_(column0 - ring_),
        row0_(row0 - ring_),
        distance_(view, column0_, row0_),
        flags_(span_, meshes),
        bounds_m_(static_cast<std::size_t>(meshes)) {}

  std::vector<SplitFlags> run() {
    for (std::int64_t y = 0; y <= span_; y += square_) {
      for (std::int64_t x = 0; x <= span_; x += square_) flags_.set(0, x, y);
    }
    const std::int64_t last = span_ - square_;
    for (std::int64_t y = square_; y < last; y += square_) {
      for (std::int64_t x = square_; x < last; x += square_) search_square(x, y);
    }
    for (const std::int64_t line : {ring_, ring_ + level_.cells}) {
      for (std::int64_t i = 0; i < span_; i += square_) {
        search_line(i, line, false);
        search_line(i, line, true);
      }
    }
    for (std::int64_t y = 0; y <= last; y += square_) {
      const bool whole_row = y == 0 || y == last;
      for (std::int64_t x = 0; x <= last; x += whole_row ? square_ : last) search_outer(x, y);
    }
    return flags_.take();
  }

 private:
  static constexpr std::int64_t kBase = SquareSamples::kCells;
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();
  /// The error where there is no surface.
  static constexpr double kNothing = -kUnknown;

  codec::CellRect rect(std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height) const {
    return {column0_ + x, row0_ + y, column0_ + x + width, row0_ + y + height};
  }

  /// Whether any cell of the DEM lies in the square.
  bool holds_cells(std::int64_t x, std::int64_t y) const {
    const cache::HeightBlocks& blocks = view_->surface().blocks();
    return column0_ + x + square_ > 0 && row0_ + y + square_ > 0 && column0_ + x < blocks.columns() - 1 &&
           row0_ + y < blocks.rows() - 1;
  }

  Point corner(std::int64_t x, std::int64_t y) {
    const double h = distance_.surface().sample(x, y);
    return {static_cast<double>(x), static_cast<double>(y), std::isnan(h) ? 0 : level_.heights.snapped_m(h)};
  }

  /// The bounds of all meshes, tested over some cells.
  void set_bounds(const codec::CellRect& cells) {
    double bound_m = level_.bound_m;
    for (auto b = bounds_m_.rbegin(); b != bounds_m_.rend(); ++b, bound_m *= 2)
      *b = tested_bound_m(view_->surface(), cells, bound_m);
  }

  /// Sets the flag of a point and of all whose triangles have to be split before its own exist.
  void force(std::size_t mesh, std::int64_t x, std::int64_t y) {
    codec::force_split({x, y}, [&](const codec::SplitPoint& p) {
      return p.x >= 0 && p.y >= 0 && p.x <= span_ && p.y <= span_ && flags_.set(mesh, p.x, p.y);
    });
  }

  /// Both halves of a unit cell become triangles of their own where an error is beyond the bound.
  void force_cell(std::int64_t x, std::int64_t y, double error) {
    std::size_t mesh = bounds_m_.size();
    while (mesh > 0 && error > bounds_m_[mesh - 1]) --mesh;
    const bool even = ((x + y) & 1) == 0;
    force(mesh, even ? x + 1 : x, y);
    force(mesh, even ? x : x + 1, y + 1);
  }

  /// The error of two parts together. Where one is missing and the other is not, its corners are not all there.
  static double both(double a, double b) { return (a == kNothing) == (b == kNothing) ? std::max(a, b) : kUnknown; }

  /// Bounds of the errors of a square's two halves: the one with the north side, the one with the south side.
  struct Halves {
    double north = kUnknown;
    double south = kUnknown;
  };

  /// A bound for all triangles inside the square that the residual pyramid gives: their corners, snapped, lie in
  /// the patch's slab, so the triangles do too.
  double slab_error(std::int64_t x, std::int64_t y, std::int64_t side) const {
    const cache::HeightBlocks& blocks = view_->surface().blocks();
    const std::int64_t column = column0_ + x;
    const std::int64_t row = row0_ + y;
    if (column < 0 || row < 0 || column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return kNothing;
    const auto size = std::ranges::find(kPatchCells, side) - kPatchCells.begin();
    if (size == static_cast<std::ptrdiff_t>(kPatchCells.size())) return kUnknown;
    const PlanePatch& patch =
        view_->surface()
            .patches(column >> 8, row >> 8)
            .at(static_cast<int>(size), static_cast<int>(column & 255), static_cast<int>(row & 255));
    if (patch.empty()) return kNothing;
    const double error = static_cast<double>(patch.high) - static_cast<double>(patch.low) + level_.heights.step_m / 2;
    return std::isnan(error) ? kUnknown : error;
  }

  void search_square(std::int64_t x, std::int64_t y) {
    if (view_->interrupted() || !holds_cells(x, y)) return;
    set_bounds(rect(x, y, square_, square_));
    search(x, y, square_);
  }

  /// A square of the window's outermost ring. All that can come of it for triangles that touch the tile is that the
  /// next square towards the tile is split at its centre and in the middle of its sides: forced splits reach half a
  /// square, in steps that double.
  void search_outer(std::int64_t x, std::int64_t y) {
    const std::int64_t half = square_ / 2;
    const std::int64_t cx = std::clamp(x, square_, span_ - 2 * square_) + half;
    const std::int64_t cy = std::clamp(y, square_, span_ - 2 * square_) + half;
    if (!split_all_round(cx, cy, half)) search_square(x, y);
  }

  /// Whether all meshes split a square at its centre (x, y) and in the middle of its sides.
  bool split_all_round(std::int64_t x, std::int64_t y, std::int64_t half) const {
    return flags_.all(x, y) && flags_.all(x, y - half) && flags_.all(x, y + half) && flags_.all(x - half, y) &&
           flags_.all(x + half, y);
  }

  /// Tests all triangles inside a square, small ones first.
  Halves search(std::int64_t x0, std::int64_t y0, std::int64_t side) {
    const double slab = slab_error(x0, y0, side);
    if (slab <= bounds_m_.back()) return {slab, slab};
    if (side == kBase && loaded_.read(*view_, column0_ + x0, row0_ + y0, level_.heights)) return search_loaded(x0, y0);
    if (side == 1) return {};
    const std::int64_t half = side / 2;
    const Halves nw = search(x0, y0, half);
    const Halves ne = search(x0 + half, y0, half);
    const Halves sw = search(x0, y0 + half, half);
    const Halves se = search(x0 + half, y0 + half, half);
    return test_square(x0, y0, side, {nw, ne, sw, se}, [this](std::int64_t x, std::int64_t y) { return corner(x, y); });
  }

  /// search() on the copied samples: from unit cells upward, the error of a triangle is at most that of its two
  /// halves and as much as its plane lies off their common corner. Only where that is not enough are the samples
  /// under it looked at.
  Halves search_loaded(std::int64_t x0, std::int64_t y0) {
    for (std::size_t j = 0; j < kBase; ++j) {
      for (std::size_t i = 0; i < kBase; ++i) {
        const double nw = std::abs(loaded_.snapped[j][i] - loaded_.samples[j][i]);
        const double ne = std::abs(loaded_.snapped[j][i + 1] - loaded_.samples[j][i + 1]);
        const double sw = std::abs(loaded_.snapped[j + 1][i] - loaded_.samples[j + 1][i]);
        const double se = std::abs(loaded_.snapped[j + 1][i + 1] - loaded_.samples[j + 1][i + 1]);
        if (((i + j) & 1) == 0) {
          halves_[j][i] = {std::max({nw, ne, se}), std::max({nw, sw, se})};
          continue;
        }
        // Cut against the surface's own diagonal.
        const double off = std::abs((loaded_.snapped[j][i + 1] + loaded_.snapped[j + 1][i]) / 2 -
                                    (loaded_.samples[j][i] + loaded_.samples[j + 1][i + 1]) / 2);
        halves_[j][i] = {std::max({nw, ne, sw, off}), std::max({ne, sw, se, off})};
        if (off > bounds_m_.back())
          force_cell(x0 + static_cast<std::int64_t>(i), y0 + static_cast<std::int64_t>(j), off);
      }
    }
    const auto loaded = [&](std::int64_t x, std::int64_t y) {
      return Point{static_cast<double>(x), static_cast<double>(y),
                   loaded_.snapped[static_cast<std::size_t>(y - y0)][static_cast<std::size_t>(x - x0)]};
    };
    for (std::size_t side = 2; side <= kBase; side *= 2) {
      const std::size_t half = side / 2;
      for (std::size_t j = 0; j < kBase; j += side) {
        for (std::size_t i = 0; i < kBase; i += side) {
          halves_[j][i] = test_square(
              x0 + static_cast<std::int64_t>(i), y0 + static_cast<std::int64_t>(j), static_cast<std::int64_t>(side),
              {halves_[j][i], halves_[j][i + half], halves_[j + half][i], halves_[j + half][i + half]}, loaded);
        }
      }
    }
    return halves_[0][0];
  }

  /// The middle (x, y) of a triangle's longest side a-b, with what is known of the triangle's two halves: flags it
  /// in the meshes where the triangle does not fit. Returns a bound of the triangle's error for the others.
  double test(const Point& a, const Point& b, const Point& c, double middle_m, double halves_error, std::int64_t x,
              std::int64_t y) {
    std::size_t mesh = flags_.first(x, y);
    if (mesh == 0) return kUnknown;
    if (halves_error == kNothing) return kNothing;
    const double error = halves_error + std::abs((a.z + b.z) / 2 - middle_m);
    for (; mesh > 0 && error > bounds_m_[mesh - 1]; --mesh) {
      switch (distance_.fit_triangle(a, b, c, bounds_m_[mesh - 1])) {
        case SurfaceDistance::Fit::kWithin:
          return bounds_m_[mesh - 1];
        case SurfaceDistance::Fit::kMissing:
          return kNothing;
        case SurfaceDistance::Fit::kBeyond:
          force(mesh - 1, x, y);
      }
    }
    return mesh == 0 ? kUnknown : error;
  }

  /// The triangles of one square: four over its sides, and its two halves. `parts` are its quarters, north-west,
  /// north-east, south-west, south-east.
  template <typename Corner>
  Halves test_square(std::int64_t x, std::int64_t y, std::int64_t side, const std::array<Halves, 4>& parts,
                     const Corner& corner_at) {
    const std::int64_t half = side / 2;
    const std::int64_t east = x + side;
    const std::int64_t south = y + side;
    if (split_all_round(x + half, y + half, half)) return {};
    const auto& [nw_part, ne_part, sw_part, se_part] = parts;
    const Point nw = corner_at(x, y);
    const Point ne = corner_at(east, y);
    const Point sw = corner_at(x, south);
    const Point se = corner_at(east, south);
    const Point centre = corner_at(x + half, y + half);
    const double over_north =
        test(nw, ne, centre, corner_at(x + half, y).z, both(nw_part.north, ne_part.north), x + half, y);
    const double over_south =
        test(sw, se, centre, corner_at(x + half, south).z, both(sw_part.south, se_part.south), x + half, south);
    const double over_west =
        test(nw, sw, centre, corner_at(x, y + half).z, both(nw_part.south, sw_part.north), x, y + half);
    const double over_east =
        test(ne, se, centre, corner_at(east, y + half).z, both(ne_part.south, se_part.north), east, y + half);
    const bool even = ((x / side + y / side) & 1) == 0;
    const std::int64_t mx = x + half;
    const std::int64_t my = y + half;
    if (even) {
      const double north = test(nw, se, ne, centre.z, both(over_north, over_east), mx, my);
      return {north, test(nw, se, sw, centre.z, both(over_south, over_west), mx, my)};
    }
    const double north = test(ne, sw, nw, centre.z, both(over_north, over_west), mx, my);
    return {north, test(ne, sw, se, centre.z, both(over_south, over_east), mx, my)};
  }

  /// Tests the edges along one square's length of a line that tiles share, against half the bound.
  void search_line(std::int64_t start, std::int64_t line, bool southward) {
    const std::int64_t n = square_;
    const codec::CellRect cells = southward ? rect(line, start, 0, n) : rect(start, line, n, 0);
    set_bounds(cells);
    if (southward)
      line_.read(distance_.surface(), line, start, n, true);
    else
      line_.read(distance_.surface(), start, line, n, false);
    for (std::int64_t side = 2; side <= n; side *= 2) {
      for (std::int64_t i = 0; i < n; i += side) {
        const std::int64_t middle = start + i + side / 2;
        const std::int64_t x = southward ? line : middle;
        const std::int64_t y = southward ? middle : line;
        // Missing samples are the triangles' concern.
        for (std::size_t mesh = flags_.first(x, y);
             mesh > 0 && !line_.edge_fits(i, side, level_.heights, bounds_m_[mesh - 1] / 2); --mesh)
          force(mesh - 1, x, y);
      }
    }
  }

  SurfaceView* view_;
  LevelGrid level_;
  std::int64_t square_;
  std::int64_t ring_;
  std::int64_t span_;
  std::int64_t column0_;
  std::int64_t row0_;
  SurfaceDistance distance_;
  NestedFlags flags_;
  std::vector<double> bounds_m_;  // of the square that is being searched, coarsest mesh first
  SquareSamples loaded_;
  std::array<std::array<Halves, kBase>, kBase> halves_;  // of the squares with this north-west corner
  LineSamples line_;
};

}  // namespace

SplitFlags find_splits(SurfaceView& view, const LevelGrid& level, std::int64_t column0, std::int64_t row0) {
  return std::move(SplitSearch(view, level, 1, column0, row0).run().front());
}

std::vector<SplitFlags> find_nested_splits(SurfaceView& view, const LevelGrid& finest, int meshes, std::int64_t column0,
                                           std::int64_t row0) {
  return SplitSearch(view, finest, meshes, column0, row0).run();
}

}  // namespace tintree::simplify
