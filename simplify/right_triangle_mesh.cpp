#include "simplify/right_triangle_mesh.h"

#include <cmath>
#include <cstdlib>

#include "simplify/split_flags.h"

namespace tintree::simplify {
namespace {

struct GridPoint {
  std::int64_t x;
  std::int64_t y;
};

/// Decides which right triangles to split. Points are classified by their coordinates: with u the largest
/// power of two that divides both, (x / u, y / u) both odd is the centre of a square of side 2u, one odd the
/// middle of such a square's side. Each is the middle of the hypotenuse of two triangles (one at the tile's
/// border), and splitting there needs the coarser triangles split first.
class Splitter {
 public:
  Splitter(SurfaceDistance& distance, const SurfaceView& view, std::int64_t column0, std::int64_t row0,
           std::int64_t cells, double bound_m, const HeightLattice& heights)
      : distance_(&distance),
        view_(&view),
        column0_(column0),
        row0_(row0),
        cells_(cells),
        bound_m_(bound_m),
        heights_(heights),
        flags_(cells) {}

  SplitFlags run() {
    force_border();
    for (std::int64_t y = 0; y < cells_ && !distance_->interrupted(); y += kSquare) {
      for (std::int64_t x = 0; x < cells_; x += kSquare) {
        if (is_active(x, y, kSquare)) split_square(x, y);
      }
    }
    for (std::int64_t side = 2 * kSquare; side <= cells_; side *= 2) split_all(0, 0, cells_, side);
    for (const std::int64_t x : {std::int64_t{0}, cells_}) {
      for (const std::int64_t y : {std::int64_t{0}, cells_}) flags_.set(x, y);
    }
    return std::move(flags_);
  }

 private:
  static constexpr std::int64_t kSquare = kPatchCells[0];

  Point corner(std::int64_t x, std::int64_t y) {
    const double h = distance_->sample(x, y);
    return {static_cast<double>(x), static_cast<double>(y), std::isnan(h) ? 0 : heights_.snapped_m(h)};
  }

  /// Sets the flag of a point and of all whose triangles have to be split before its own exist.
  void force(std::int64_t x, std::int64_t y) {
    if (!flags_.set(x, y)) return;
    const std::int64_t unit = (x | y) & -(x | y);
    const bool odd_x = (x & unit) != 0;
    const bool odd_y = (y & unit) != 0;
    if (odd_x && odd_y) {
      if (2 * unit >= cells_) return;
      // The square's corners of mixed parity are the middles of the coarser square's sides.
      const std::int64_t side = 2 * unit;
      const std::int64_t west = x - unit;
      const std::int64_t north = y - unit;
      const bool even = ((west / side + north / side) & 1) == 0;
      force(even ? west + side : west, north);
      force(even ? west : west + side, north + side);
    } else if (odd_x) {
      if (y - unit >= 0) force(x, y - unit);
      if (y + unit <= cells_) force(x, y + unit);
    } else {
      if (x - unit >= 0) force(x - unit, y);
      if (x + unit <= cells_) force(x + unit, y);
    }
  }

  /// Both halves of a unit cell become triangles of their own.
  void force_cell(std::int64_t x, std::int64_t y) {
    const bool even = ((x + y) & 1) == 0;
    force(even ? x + 1 : x, y);
    force(even ? x : x + 1, y + 1);
  }

  bool has_samples(std::int64_t x, std::int64_t y) {
    for (int k = 0; k < 4; ++k) {
      if (!std::isnan(distance_->sample(x + (k & 1), y + (k >> 1)))) return true;
    }
    return false;
  }

  void force_border() {
    for (std::int64_t i = 0; i < cells_; ++i) {
      if (has_samples(i, 0)) force_cell(i, 0);
      if (has_samples(i, cells_ - 1)) force_cell(i, cells_ - 1);
      if (has_samples(0, i)) force_cell(0, i);
      if (has_samples(cells_ - 1, i)) force_cell(cells_ - 1, i);
    }
  }

  /// False when the residual pyramid shows that no triangle inside the square needs splitting: its corners,
  /// snapped, lie in the patch's slab, so the triangle does too.
  bool is_active(std::int64_t x, std::int64_t y, std::int64_t side) const {
    const cache::HeightBlocks& blocks = view_->surface().blocks();
    if (cells_ < side) return true;
    const std::int64_t column = column0_ + x;
    const std::int64_t row = row0_ + y;
    if (column >= blocks.columns() - 1 || row >= blocks.rows() - 1) return false;
    const PlanePatch& patch = view_->surface()
                                  .patches(column >> 8, row >> 8)
                                  .at(0, static_cast<int>(column & 255), static_cast<int>(row & 255));
    if (patch.empty()) return false;
    const double thickness = static_cast<double>(patch.high) - static_cast<double>(patch.low);
    return !(thickness + heights_.step_m / 2 <= bound_m_);
  }

  void split_square(std::int64_t x0, std::int64_t y0) {
    const std::int64_t extent = std::min(kSquare, cells_);
    const bool complete = extent == kSquare && load_square(x0, y0);
    if (complete) split_smallest(x0, y0);
    for (std::int64_t side = complete ? 4 : 2; side <= extent; side *= 2) split_all(x0, y0, extent, side);
  }

  /// Copies a square's samples; false when one is missing.
  bool load_square(std::int64_t x0, std::int64_t y0) {
    for (std::size_t j = 0; j < kLine; ++j) {
      for (std::size_t i = 0; i < kLine; ++i) {
        const double h = distance_->sample(x0 + static_cast<std::int64_t>(i), y0 + static_cast<std::int64_t>(j));
        if (std::isnan(h)) return false;
        samples_[j][i] = h;
        snapped_[j][i] = heights_.snapped_m(h);
      }
    }
    return true;
  }

  /// The tests of split_side() for squares of side 2, on the copied samples: the middle of each side and the
  /// centre against the corners, and the unit diagonals that run against the surface's.
  void split_smallest(std::int64_t x0, std::int64_t y0) {
    const auto beyond = [this](double mesh, double surface) { return !(std::abs(mesh - surface) <= bound_m_); };
    for (std::size_t j = 0; j + 1 < kLine; j += 2) {
      const auto& north = snapped_[j];
      const auto& south = snapped_[j + 2];
      const auto* h = &samples_[j];
      for (std::size_t i = 0; i + 1 < kLine; i += 2) {
        const std::int64_t x = x0 + static_cast<std::int64_t>(i);
        const std::int64_t y = y0 + static_cast<std::int64_t>(j);
        const double centre = snapped_[j + 1][i + 1];
        if (beyond((north[i] + north[i + 2]) / 2, h[0][i + 1])) force(x + 1, y);
        if (beyond((south[i] + south[i + 2]) / 2, h[2][i + 1])) force(x + 1, y + 2);
        if (beyond((north[i] + south[i]) / 2, h[1][i])) force(x, y + 1);
        if (beyond((north[i + 2] + south[i + 2]) / 2, h[1][i + 2])) force(x + 2, y + 1);
        const double north_east = (h[0][i + 1] + h[1][i + 2]) / 2;
        const double south_west = (h[1][i] + h[2][i + 1]) / 2;
        if (beyond((north[i + 2] + centre) / 2, north_east)) force_cell(x + 1, y);
        if (beyond((south[i] + centre) / 2, south_west)) force_cell(x, y + 1);
        const bool even = ((x / 2 + y / 2) & 1) == 0;
        const double a = even ? north[i] : north[i + 2];
        const double b = even ? south[i + 2] : south[i];
        if (beyond((a + b) / 2, h[1][i + 1]) ||
            (!even && (beyond(0.75 * a + 0.25 * b, north_east) || beyond(0.25 * a + 0.75 * b, south_west)))) {
          force(x + 1, y + 1);
        }
      }
    }
  }

  void split_all(std::int64_t x0, std::int64_t y0, std::int64_t extent, std::int64_t side) {
    for (std::int64_t y = y0; y < y0 + extent && !distance_->interrupted(); y += side) {
      for (std::int64_t x = x0; x < x0 + extent; x += side) split_side(x, y, side);
    }
  }

  void test(const Point& a, const Point& b, const Point& c, std::int64_t x, std::int64_t y) {
    if (flags_.get(x, y)) return;
    if (distance_->fit_triangle(a, b, c, bound_m_) == SurfaceDistance::Fit::kBeyond) force(x, y);
  }

  /// The triangles of one square: four over its sides, and its two halves.
  void split_side(std::int64_t x, std::int64_t y, std::int64_t side) {
    const std::int64_t half = side / 2;
    const std::int64_t east = x + side;
    const std::int64_t south = y + side;
    const bool open[4] = {!flags_.get(x + half, y), !flags_.get(x + half, south), !flags_.get(x, y + half),
                          !flags_.get(east, y + half)};
    const bool open_centre = !flags_.get(x + half, y + half);
    if (!open_centre && !open[0] && !open[1] && !open[2] && !open[3]) return;
    const Point nw = corner(x, y);
    const Point ne = corner(east, y);
    const Point sw = corner(x, south);
    const Point se = corner(east, south);
    const Point centre = corner(x + half, y + half);
    if (open[0]) test(nw, ne, centre, x + half, y);
    if (open[1]) test(sw, se, centre, x + half, south);
    if (open[2]) test(nw, sw, centre, x, y + half);
    if (open[3]) test(ne, se, centre, east, y + half);
    const bool even = ((x / side + y / side) & 1) == 0;
    if (even) {
      test(nw, se, ne, x + half, y + half);
      test(nw, se, sw, x + half, y + half);
    } else {
      test(ne, sw, nw, x + half, y + half);
      test(ne, sw, se, x + half, y + half);
    }
  }

  static constexpr std::size_t kLine = kSquare + 1;

  SurfaceDistance* distance_;
  const SurfaceView* view_;
  std::int64_t column0_;
  std::int64_t row0_;
  std::int64_t cells_;
  double bound_m_;
  HeightLattice heights_;
  SplitFlags flags_;
  std::array<std::array<double, kLine>, kLine> samples_;
  std::array<std::array<double, kLine>, kLine> snapped_;
};

/// Walks the split triangles and collects vertices and triangles in that order: a space-filling curve.
class Extractor {
 public:
  Extractor(SurfaceDistance& distance, SplitFlags& flags, std::int64_t cells, const HeightLattice& heights,
            const CornerFlips& flips)
      : distance_(&distance), flags_(&flags), cells_(cells), heights_(heights), flips_(flips) {
    vertex_of_rank_.assign(static_cast<std::size_t>(flags.number()), kNone);
  }

  StartMesh run() {
    const std::int64_t n = cells_;
    descend({0, 0}, {n, n}, {n, 0});
    descend({n, n}, {0, 0}, {0, n});
    for (auto& side : mesh_.sides) side.resize(static_cast<std::size_t>(n) + 1);
    for (std::int64_t i = 0; i <= n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      mesh_.sides[0][k] = find(i, 0);
      mesh_.sides[1][k] = find(i, n);
      mesh_.sides[2][k] = find(0, i);
      mesh_.sides[3][k] = find(n, i);
    }
    return std::move(mesh_);
  }

 private:
  /// Triangle with hypotenuse a-b and apex c, counter-clockwise from above.
  void descend(GridPoint a, GridPoint b, GridPoint c) {
    if (std::abs(a.x - b.x) == 1 && std::abs(a.y - b.y) == 1) {
      emit_half_cell(a, b, c);
      return;
    }
    const GridPoint middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
    if (!flags_->get(middle.x, middle.y)) {
      emit(a, b, c);
      return;
    }
    descend(c, a, middle);
    descend(b, c, middle);
  }

  /// Half a unit cell. Where the other half is a triangle too, the two get the surface's own diagonal.
  void emit_half_cell(GridPoint a, GridPoint b, GridPoint c) {
    const GridPoint d{a.x + b.x - c.x, a.y + b.y - c.y};
    const bool whole = flags_->get(c.x, c.y) && flags_->get(d.x, d.y);
    const bool along = (a.x - b.x) == (a.y - b.y);
    const GridPoint cell{std::min(a.x, b.x), std::min(a.y, b.y)};
    const bool flipped = (flips_.north_east && cell.x == cells_ - 1 && cell.y == 0) ||
                         (flips_.south_west && cell.x == 0 && cell.y == cells_ - 1);
    if (!whole || along || flipped) {
      emit(a, b, c);
    } else {
      // The diagonal runs from c to d; of the two halves take the one on a's side.
      emit(c, a, d);
    }
  }

  void emit(GridPoint a, GridPoint b, GridPoint c) {
    const std::array<std::int32_t, 3> t{vertex(a), vertex(b), vertex(c)};
    if (t[0] == kNone || t[1] == kNone || t[2] == kNone) return;
    mesh_.triangles.push_back(t);
  }

  /// The vertex at a sample, made on first use; kNone when the sample is missing.
  std::int32_t vertex(GridPoint p) {
    std::int32_t& v = vertex_of_rank_[static_cast<std::size_t>(flags_->rank(p.x, p.y))];
    if (v == kNone) {
      const double h = distance_->sample(p.x, p.y);
      if (std::isnan(h)) return kNone;
      v = static_cast<std::int32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), heights_.snap(h)});
    }
    return v;
  }

  std::int32_t find(std::int64_t x, std::int64_t y) const {
    return flags_->get(x, y) ? vertex_of_rank_[static_cast<std::size_t>(flags_->rank(x, y))] : kNone;
  }

  SurfaceDistance* distance_;
  SplitFlags* flags_;
  std::int64_t cells_;
  HeightLattice heights_;
  CornerFlips flips_;
  std::vector<std::int32_t> vertex_of_rank_;
  StartMesh mesh_;
};

}  // namespace

StartMesh right_triangle_mesh(SurfaceDistance& distance, const SurfaceView& view, std::int64_t column0,
                              std::int64_t row0, std::int64_t cells, double bound_m, const HeightLattice& heights,
                              const CornerFlips& flips) {
  SplitFlags flags = Splitter(distance, view, column0, row0, cells, bound_m, heights).run();
  if (distance.interrupted()) return {};
  return Extractor(distance, flags, cells, heights, flips).run();
}

}  // namespace tintree::simplify
