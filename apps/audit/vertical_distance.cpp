#include "apps/audit/vertical_distance.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace tintree::audit {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Parameters this near a sample are taken as on it.
constexpr double kOnSample = 1e-9;

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  const std::int64_t q = a / b;
  return a % b != 0 && (a < 0) != (b < 0) ? q - 1 : q;
}
std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return -floor_div(-a, b); }

/// The samples at or before and after places in lattice units, of which a power of two make a sample; a division for
/// each would take a fifth of the time where triangles are as small as cells.
class Samples {
 public:
  explicit Samples(int units) : shift_(std::countr_zero(static_cast<unsigned>(units))) {}
  std::int64_t before(std::int64_t place) const { return place >> shift_; }
  std::int64_t after(std::int64_t place) const { return -(-place >> shift_); }

 private:
  int shift_;
};

/// The side function of a triangle's edge: twice the area between the edge and a point, as a linear
/// function of the point; not negative inside.
struct SideFunction {
  SideFunction(const Corner& from, const Corner& to)
      : per_x(std::int64_t{to.y} - from.y),
        per_y(std::int64_t{from.x} - to.x),
        constant(-per_x * from.x - per_y * from.y) {}
  std::int64_t at(std::int64_t x, std::int64_t y) const { return constant + per_x * x + per_y * y; }

  std::int64_t per_x;
  std::int64_t per_y;
  std::int64_t constant;
};

/// Narrows columns [first, last] to those where the side function is not negative; exact.
void narrow(const SideFunction& side, std::int64_t y, std::int64_t units, std::int64_t& first, std::int64_t& last) {
  const std::int64_t start = side.at(0, y);
  const std::int64_t step = side.per_x * units;
  if (step > 0) first = std::max(first, ceil_div(-start, step));
  if (step < 0) last = std::min(last, floor_div(start, -step));
  if (step == 0 && start < 0) last = first - 1;
}

/// One family of parallel grid lines, as seen along a mesh edge.
struct Crossings {
  const HeightWindow& window;
  const Corner& a;
  const Corner& b;
  int units;
  double rise;  // of the edge, metres

  /// Visits the lines on which a coordinate that is `from` at a and `to` at b (lattice units) is a
  /// multiple of the sample spacing, numbers clipped to [low, high]. Not those through the edge's ends, which
  /// measure_corner() compares.
  template <typename Visit>
  void lines(std::int64_t from, std::int64_t to, std::int64_t low, std::int64_t high, const Visit& visit) const {
    const auto [smaller, larger] = std::minmax(from, to);
    const std::int64_t first = std::max(samples.before(smaller) + 1, low);
    const std::int64_t last = std::min(samples.after(larger) - 1, high);
    const auto length = static_cast<double>(to - from);
    for (std::int64_t k = first; k <= last; ++k) visit(k, static_cast<double>(k * units - from) / length);
  }

  /// Where along a grid line the edge is at `t`: the sample before it and the share of the way to the next.
  /// `from` and `to` are the edge's ends in the coordinate that runs along the line.
  struct Place {
    std::int64_t sample;
    double share;
  };
  Place place(std::int32_t from, std::int32_t to, double t) const {
    // Relative to the edge's own start, for precision far from the tile's corner.
    const std::int64_t whole = samples.before(from);
    const double start = static_cast<double>(from - whole * units) / units;
    const double along = start + t * (static_cast<double>(std::int64_t{to} - from) / units);
    const double k = std::floor(along + kOnSample);
    return {whole + static_cast<std::int64_t>(k), std::max(along - k, 0.0)};
  }

  double height(double t) const { return a.z_m + t * rise; }

  Samples samples{units};
};

bool within(std::int64_t sample, double share, std::int64_t low, std::int64_t high) {
  return sample >= low && (sample < high || (sample == high && share < kOnSample));
}

void offer_rows(const Crossings& c, Peak& peak) {
  const codec::CellRect& w = c.window.cells();
  c.lines(c.a.y, c.b.y, w.row0, w.row1, [&](std::int64_t r, double t) {
    const auto [k, share] = c.place(c.a.x, c.b.x, t);
    if (!within(k, share, w.column0, w.column1)) return;
    const double* line = c.window.row(r);
    const double s = share < kOnSample ? line[k] : line[k] + share * (line[k + 1] - line[k]);
    peak.offer(std::abs(c.height(t) - s), static_cast<double>(k) + share, static_cast<double>(r));
  });
}

void offer_columns(const Crossings& c, Peak& peak) {
  const codec::CellRect& w = c.window.cells();
  c.lines(c.a.x, c.b.x, w.column0, w.column1, [&](std::int64_t column, double t) {
    const auto [k, share] = c.place(c.a.y, c.b.y, t);
    if (!within(k, share, w.row0, w.row1)) return;
    const double first = c.window.at(column, k);
    const double s = share < kOnSample ? first : first + share * (c.window.at(column, k + 1) - first);
    peak.offer(std::abs(c.height(t) - s), static_cast<double>(column), static_cast<double>(k) + share);
  });
}

/// Diagonals: column - row is whole.
void offer_diagonals(const Crossings& c, Peak& peak) {
  const codec::CellRect& w = c.window.cells();
  const std::int64_t from = std::int64_t{c.a.x} - c.a.y;
  const std::int64_t to = std::int64_t{c.b.x} - c.b.y;
  c.lines(from, to, w.column0 - w.row1, w.column1 - w.row0, [&](std::int64_t m, double t) {
    const auto [k, share] = c.place(c.a.y, c.b.y, t);
    if (!within(k, share, w.row0, w.row1) || !within(k + m, share, w.column0, w.column1)) return;
    const double first = c.window.at(k + m, k);
    const double s = share < kOnSample ? first : first + share * (c.window.at(k + m + 1, k + 1) - first);
    peak.offer(std::abs(c.height(t) - s), static_cast<double>(k + m) + share, static_cast<double>(k) + share);
  });
}

/// Whether both points lie on one and the same side of the tile's full square.
bool on_one_side(const TileSurface& s, const Corner& a, const Corner& b) {
  const std::int64_t far = s.across * s.units;
  return (a.x == b.x && (a.x == 0 || a.x == far)) || (a.y == b.y && (a.y == 0 || a.y == far));
}

void measure_corner(const TileSurface& s, const HeightWindow& window, const Corner& p, VerticalDistance& out) {
  const double d = std::abs(p.z_m - window.surface(p.x, p.y, s.units));
  const double column = static_cast<double>(p.x) / s.units;
  const double row = static_cast<double>(p.y) / s.units;
  out.overall.offer(d, column, row);
  if (on_one_side(s, p, p)) out.border.offer(d, column, row);
}

void measure_edge(const TileSurface& s, const HeightWindow& window, const Edge& edge, VerticalDistance& out) {
  const Corner& a = s.corners[edge.a];
  const Corner& b = s.corners[edge.b];
  const Crossings crossings{window, a, b, s.units, b.z_m - a.z_m};
  Peak peak;
  offer_rows(crossings, peak);
  offer_columns(crossings, peak);
  offer_diagonals(crossings, peak);
  out.overall.offer(peak);
  if (edge.open && on_one_side(s, a, b)) out.border.offer(peak);
}

}  // namespace

void VerticalDistance::add(const VerticalDistance& other) {
  overall.offer(other.overall);
  border.offer(other.border);
  sum_squares_m2 += other.sum_squares_m2;
  samples += other.samples;
}

void VerticalMeasure::scan(const TileSurface& s, const HeightWindow& window, const codec::Triangle& triangle) {
  const Corner& a = s.corners[triangle[0]];
  const Corner& b = s.corners[triangle[1]];
  const Corner& c = s.corners[triangle[2]];
  const codec::CellRect& w = window.cells();
  const std::int64_t units = s.units;
  // The weight of a corner is the side function of the edge that faces it.
  const std::array<SideFunction, 3> sides{SideFunction(b, c), SideFunction(c, a), SideFunction(a, b)};
  const double share = 1 / static_cast<double>(doubled_area(a, b, c));
  const double rise_b = (b.z_m - a.z_m) * share;
  const double rise_c = (c.z_m - a.z_m) * share;
  const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
  const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
  const Samples samples(s.units);
  const std::int64_t row0 = std::max(samples.after(y0), w.row0);
  const std::int64_t row1 = std::min(samples.before(y1), w.row0 + own_rows_ - 1);
  for (std::int64_t r = row0; r <= row1; ++r) {
    std::int64_t first = std::max(samples.after(x0), w.column0);
    std::int64_t last = std::min(samples.before(x1), w.column0 + own_columns_ - 1);
    for (const SideFunction& side : sides) narrow(side, r * units, units, first, last);
    if (first > last) continue;
    const auto weight_b = static_cast<double>(sides[1].at(first * units, r * units));
    const auto weight_c = static_cast<double>(sides[2].at(first * units, r * units));
    const auto step_b = static_cast<double>(sides[1].per_x * units);
    const auto step_c = static_cast<double>(sides[2].per_x * units);
    double* out = mesh_heights_.data() + (r - w.row0) * own_columns_ + (first - w.column0);
    const auto count = static_cast<int>(last - first + 1);
    for (int i = 0; i < count; ++i) {
      out[i] = a.z_m + ((weight_b + i * step_b) * rise_b + (weight_c + i * step_c) * rise_c);
    }
  }
}

namespace {

/// What one row of samples adds up to.
struct RowSums {
  double squares = 0;
  double largest = 0;
  std::uint64_t samples = 0;
};

/// Turns mesh heights into distances. Sums in lanes, which the compiler can keep in one register.
RowSums compare_row(const double* reference, double* mesh, std::int64_t count) {
  constexpr std::int64_t kLanes = 4;
  std::array<double, kLanes> squares{};
  std::array<double, kLanes> largest{};
  std::array<double, kLanes> samples{};
  const auto take = [&](std::int64_t i, std::size_t lane) {
    const double d = std::abs(mesh[i] - reference[i]);
    mesh[i] = d;
    const bool there = d >= 0;
    const double counted = there ? d : 0;
    squares[lane] += counted * counted;
    largest[lane] = counted > largest[lane] ? counted : largest[lane];
    samples[lane] += there ? 1 : 0;
  };
  std::int64_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) take(i + static_cast<std::int64_t>(lane), lane);
  }
  for (; i < count; ++i) take(i, 0);
  RowSums sums;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    sums.squares += squares[lane];
    sums.largest = std::max(sums.largest, largest[lane]);
    sums.samples += static_cast<std::uint64_t>(samples[lane]);
  }
  return sums;
}

}  // namespace

void VerticalMeasure::compare_samples(const HeightWindow& window, VerticalDistance& out) {
  const codec::CellRect& w = window.cells();
  for (std::int64_t j = 0; j < own_rows_; ++j) {
    double* mesh = mesh_heights_.data() + j * own_columns_;
    const RowSums row = compare_row(window.row(w.row0 + j) + w.column0, mesh, own_columns_);
    out.samples += row.samples;
    out.sum_squares_m2 += row.squares;
    if (row.largest <= out.overall.value_m) continue;
    const std::int64_t at = std::find(mesh, mesh + own_columns_, row.largest) - mesh;
    out.overall = {row.largest, static_cast<double>(w.column0 + at), static_cast<double>(w.row0 + j)};
  }
  errors_ = {w.column0, w.row0, own_columns_, own_rows_, mesh_heights_};
}

VerticalDistance VerticalMeasure::measure(const TileSurface& surface, const HeightWindow& window,
                                          const WindowParts& parts) {
  const codec::CellRect& w = window.cells();
  own_columns_ = w.column1 - w.column0 + (parts.closed || w.column1 == window.tile_width() ? 1 : 0);
  own_rows_ = w.row1 - w.row0 + (parts.closed || w.row1 == window.tile_height() ? 1 : 0);
  mesh_heights_.assign(static_cast<std::size_t>(own_columns_ * own_rows_), kNaN);
  for (const std::uint32_t t : parts.triangles) scan(surface, window, surface.triangles[t]);
  VerticalDistance out;
  compare_samples(window, out);
  for (const std::uint32_t v : parts.corners) measure_corner(surface, window, surface.corners[v], out);
  for (const std::uint32_t e : parts.edges) measure_edge(surface, window, surface.edges[e], out);
  return out;
}

}  // namespace tintree::audit
