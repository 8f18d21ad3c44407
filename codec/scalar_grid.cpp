#include "codec/scalar_grid.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tintree::codec {
namespace {

/// Names the vertices of a grid by their place.
class Numbering {
 public:
  explicit Numbering(const ScalarGrid& grid) : grid_(&grid) {
    std::size_t next = 0;
    for (std::size_t side = 0; side < 4; ++side) {
      first_[side] = next;
      const std::size_t count = grid.sides[side].size();
      next += side == ScalarGrid::kNorth ? count : side == ScalarGrid::kWest ? count - 2 : count - 1;
    }
    inner_ = next;
  }

  std::size_t border_count() const { return inner_; }
  std::uint32_t inner(std::int64_t column, std::int64_t row) const {
    return static_cast<std::uint32_t>(inner_ + static_cast<std::size_t>(row * grid_->columns() + column));
  }
  /// Vertex k of a side.
  std::uint32_t border(int side, std::size_t k) const {
    const bool last = k + 1 == grid_->sides[static_cast<std::size_t>(side)].size();
    switch (side) {
      case ScalarGrid::kEast:
        return k == 0 ? number(ScalarGrid::kNorth, grid_->sides[ScalarGrid::kNorth].size() - 1) : number(side, k - 1);
      case ScalarGrid::kSouth:
        return last ? number(ScalarGrid::kEast, grid_->sides[ScalarGrid::kEast].size() - 2) : number(side, k);
      case ScalarGrid::kWest:
        return k == 0 ? 0 : last ? number(ScalarGrid::kSouth, 0) : number(side, k - 1);
      default:
        return number(side, k);
    }
  }

 private:
  std::uint32_t number(int side, std::size_t k) const {
    return static_cast<std::uint32_t>(first_[static_cast<std::size_t>(side)] + k);
  }

  const ScalarGrid* grid_;
  std::array<std::size_t, 4> first_{};
  std::size_t inner_ = 0;
};

/// Puts the strip's triangles together.
class Strip {
 public:
  explicit Strip(const ScalarGrid& grid)
      : grid_(&grid), numbers_(grid), last_column_(grid.columns() - 1), last_row_(grid.rows() - 1) {}

  std::vector<Triangle> make() {
    if (grid_->inner_count() == 0) {
      cut_cells();
      return std::move(out_);
    }
    for (int side = 0; side < 4; ++side) {
      // The corner cells that the surface's diagonal does not cut towards their corner are two sides' at once.
      const auto counts = trimmed(side);
      run(side, counts[0], counts[1]);
    }
    if (own_diagonal(ScalarGrid::kNorth)) {
      const std::uint32_t nw = numbers_.border(ScalarGrid::kNorth, size(ScalarGrid::kNorth) - 2);
      const std::uint32_t se = numbers_.border(ScalarGrid::kEast, 1);
      out_.push_back({nw, se, numbers_.border(ScalarGrid::kEast, 0)});
      out_.push_back({nw, numbers_.inner(last_column_, 0), se});
    }
    if (own_diagonal(ScalarGrid::kWest)) {
      const std::uint32_t nw = numbers_.border(ScalarGrid::kWest, size(ScalarGrid::kWest) - 2);
      const std::uint32_t se = numbers_.border(ScalarGrid::kSouth, 1);
      out_.push_back({nw, numbers_.border(ScalarGrid::kSouth, 0), se});
      out_.push_back({nw, se, numbers_.inner(0, last_row_)});
    }
    return std::move(out_);
  }

 private:
  std::size_t size(int side) const { return places(side).size(); }
  const std::vector<std::int32_t>& places(int side) const { return grid_->sides[static_cast<std::size_t>(side)]; }
  bool horizontal(int side) const { return side == ScalarGrid::kNorth || side == ScalarGrid::kSouth; }
  std::int64_t inner_last(int side) const { return horizontal(side) ? last_column_ : last_row_; }
  /// Place along the side of vertex k of the grid's line next to it.
  std::int64_t inner_place(std::int64_t k) const { return (k + 1) * grid_->stride; }
  std::uint32_t inner(int side, std::int64_t k) const {
    switch (side) {
      case ScalarGrid::kNorth:
        return numbers_.inner(k, 0);
      case ScalarGrid::kSouth:
        return numbers_.inner(k, last_row_);
      case ScalarGrid::kWest:
        return numbers_.inner(0, k);
      default:
        return numbers_.inner(last_column_, k);
    }
  }

  /// Whether the north-east (of the north side) or south-west (of the west side) corner cell has just its corners.
  bool own_diagonal(int side) const {
    const std::vector<std::int32_t>& ends = places(side);
    const std::vector<std::int32_t>& begins =
        places(side == ScalarGrid::kNorth ? ScalarGrid::kEast : ScalarGrid::kSouth);
    return ends[ends.size() - 2] == inner_place(inner_last(side)) && begins[1] == grid_->stride;
  }

  /// First and last vertex of the side that its own run of triangles reaches.
  std::array<std::size_t, 2> trimmed(int side) const {
    const bool begins = (side == ScalarGrid::kEast && own_diagonal(ScalarGrid::kNorth)) ||
                        (side == ScalarGrid::kSouth && own_diagonal(ScalarGrid::kWest));
    const bool ends = (side == ScalarGrid::kNorth || side == ScalarGrid::kWest) && own_diagonal(side);
    return {begins ? 1U : 0U, size(side) - (ends ? 2 : 1)};
  }

  void run(int side, std::size_t outer, std::size_t outer_last) {
    const std::vector<std::int32_t>& line = places(side);
    // Between two edges alike, the surface's diagonal goes from the one that lies west or north.
    const bool inner_first = side == ScalarGrid::kNorth || side == ScalarGrid::kWest;
    std::int64_t k = 0;
    const std::int64_t last = inner_last(side);
    while (outer < outer_last || k < last) {
      bool move_inner = outer == outer_last;
      if (!move_inner && k < last) {
        const std::int64_t inner_middle = inner_place(k) + inner_place(k + 1);
        const std::int64_t outer_middle = std::int64_t{line[outer]} + line[outer + 1];
        move_inner = inner_middle < outer_middle || (inner_middle == outer_middle && inner_first);
      }
      const std::uint32_t a = numbers_.border(side, outer);
      const std::uint32_t b = inner(side, k);
      const std::uint32_t c = move_inner ? inner(side, k + 1) : numbers_.border(side, outer + 1);
      // Rising places turn counter-clockwise along the north and east sides.
      const bool rising = side == ScalarGrid::kNorth || side == ScalarGrid::kEast;
      out_.push_back(rising ? Triangle{a, b, c} : Triangle{a, c, b});
      if (move_inner)
        ++k;
      else
        ++outer;
    }
  }

  /// A tile one step wide or high: every vertex lies on a side.
  void cut_cells() {
    const bool wide = grid_->height == 1;
    const int first = wide ? ScalarGrid::kNorth : ScalarGrid::kWest;
    const int second = wide ? ScalarGrid::kSouth : ScalarGrid::kEast;
    const std::size_t cells = std::min(size(first), size(second)) - 1;
    for (std::size_t k = 0; k < cells; ++k) {
      const std::uint32_t nw = numbers_.border(first, k);
      const std::uint32_t se = numbers_.border(second, k + 1);
      const std::uint32_t ne = wide ? numbers_.border(first, k + 1) : numbers_.border(second, k);
      const std::uint32_t sw = wide ? numbers_.border(second, k) : numbers_.border(first, k + 1);
      out_.push_back({nw, se, ne});
      out_.push_back({nw, sw, se});
    }
  }

  const ScalarGrid* grid_;
  Numbering numbers_;
  std::int64_t last_column_;
  std::int64_t last_row_;
  std::vector<Triangle> out_;
};

}  // namespace

std::size_t ScalarGrid::border_count() const { return Numbering(*this).border_count(); }

std::vector<GridVertex> ScalarGrid::places() const {
  std::vector<GridVertex> out;
  out.reserve(vertex_count());
  for (const std::int32_t at : sides[kNorth]) out.push_back({at, 0, 0});
  for (std::size_t k = 1; k < sides[kEast].size(); ++k) out.push_back({width, sides[kEast][k], 0});
  for (std::size_t k = 0; k + 1 < sides[kSouth].size(); ++k) out.push_back({sides[kSouth][k], height, 0});
  for (std::size_t k = 1; k + 1 < sides[kWest].size(); ++k) out.push_back({0, sides[kWest][k], 0});
  for (std::int64_t row = 1; row <= rows(); ++row) {
    for (std::int64_t column = 1; column <= columns(); ++column) {
      out.push_back({static_cast<std::int32_t>(column * stride), static_cast<std::int32_t>(row * stride), 0});
    }
  }
  return out;
}

std::vector<Triangle> ScalarGrid::strip() const { return Strip(*this).make(); }

std::vector<Triangle> ScalarGrid::triangles() const {
  std::vector<Triangle> out = strip();
  const Numbering numbers(*this);
  for (std::int64_t row = 0; row + 1 < rows(); ++row) {
    for (std::int64_t column = 0; column + 1 < columns(); ++column) {
      const std::uint32_t nw = numbers.inner(column, row);
      const std::uint32_t sw = numbers.inner(column, row + 1);
      out.push_back({nw, sw + 1, nw + 1});
      out.push_back({nw, sw, sw + 1});
    }
  }
  return out;
}

namespace {

/// A triangle at one of its corners.
struct Wedge {
  std::uint32_t vertex;
  std::uint32_t from;  ///< The next corner,
  std::uint32_t to;    ///< and the one after it.
  std::size_t triangle;
  std::size_t corner;
};

/// Takes the fan that begins with one of the wedges out of the list.
std::vector<Wedge> take_fan(std::vector<Wedge>& wedges) {
  const auto begins = [&](const Wedge& w) {
    return std::ranges::none_of(wedges, [&](const Wedge& other) { return other.to == w.from; });
  };
  auto next = std::ranges::find_if(wedges, begins);
  if (next == wedges.end()) next = wedges.begin();  // all round
  std::vector<Wedge> fan;
  while (next != wedges.end()) {
    fan.push_back(*next);
    wedges.erase(next);
    next = std::ranges::find(wedges, fan.back().to, &Wedge::from);
  }
  return fan;
}

/// Where triangles meet in a vertex alone each fan of them gets a vertex of its own. `pinched`: vertices that may be
/// such.
void split_fans(TileMesh& mesh, const std::vector<bool>& pinched) {
  std::vector<Wedge> wedges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      if (pinched[t[k]]) wedges.push_back({t[k], t[(k + 1) % 3], t[(k + 2) % 3], i, k});
    }
  }
  std::ranges::stable_sort(wedges, {}, &Wedge::vertex);
  std::vector<Wedge> around;
  for (auto first = wedges.begin(); first != wedges.end();) {
    const auto last =
        std::ranges::find_if(first, wedges.end(), [v = first->vertex](const Wedge& w) { return w.vertex != v; });
    around.assign(first, last);
    static_cast<void>(take_fan(around));
    while (!around.empty()) {
      const auto copy = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(mesh.vertices[first->vertex]);
      for (const Wedge& w : take_fan(around)) mesh.triangles[w.triangle][w.corner] = copy;
    }
    first = last;
  }
}

}  // namespace

TileMesh ScalarTile::mesh() const {
  TileMesh out;
  out.xy_shift = xy_shift;
  out.z_offset = z_offset;
  out.triangles = grid.triangles();
  out.vertices = grid.places();
  for (std::size_t i = 0; i < z.size(); ++i) out.vertices[i].z = z[i];
  if (missing.empty()) return out;
  std::vector<bool> at_hole(z.size(), false);
  std::erase_if(out.triangles, [&](const Triangle& t) {
    if (!missing[t[0]] && !missing[t[1]] && !missing[t[2]]) return false;
    for (const std::uint32_t i : t) at_hole[i] = true;
    return true;
  });
  std::vector<bool> used(z.size(), false);
  for (const Triangle& t : out.triangles) {
    for (const std::uint32_t i : t) used[i] = true;
  }
  std::vector<std::uint32_t> number(z.size(), 0);
  std::vector<bool> pinched;
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!used[i]) continue;
    out.vertices[count] = out.vertices[i];
    pinched.push_back(at_hole[i]);
    number[i] = count++;
  }
  out.vertices.resize(count);
  for (Triangle& t : out.triangles) t = {number[t[0]], number[t[1]], number[t[2]]};
  split_fans(out, pinched);
  return out;
}

std::array<double, 16> inverse_quantization(std::int32_t stride, std::int32_t step, std::int32_t offset) {
  const auto s = static_cast<double>(stride);
  return {s, 0, 0, 0, 0, s, 0, 0, 0, 0, static_cast<double>(step), 0, s, s, static_cast<double>(offset), 1};
}

}  // namespace tintree::codec
