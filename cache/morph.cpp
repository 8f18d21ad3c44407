#include "cache/morph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>
#include <utility>

namespace tintree::cache {
namespace {

/// A place on the grid relative to the tile's first sample, in the tile's address steps.
struct Place {
  double x = 0;
  double y = 0;
};

/// Twice the area of a triangle, positive when counter-clockwise seen from above (y runs south).
double doubled_area(const Place& a, const Place& b, const Place& c) {
  return (c.x - a.x) * (b.y - a.y) - (b.x - a.x) * (c.y - a.y);
}

/// A triangle of either mesh: corners, and what varies linearly over it.
struct Facet {
  std::array<Place, 3> at;
  std::array<std::array<double, 3>, 3> value{};  ///< Height in the tile's steps, the normal's two parts, a corner.

  std::array<double, 3> sample(const Place& p) const {
    const std::array<double, 3> w{doubled_area(p, at[1], at[2]), doubled_area(p, at[2], at[0]),
                                  doubled_area(p, at[0], at[1])};
    const double all = w[0] + w[1] + w[2];
    std::array<double, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = (w[0] * value[0][i] + w[1] * value[1][i] + w[2] * value[2][i]) / all;
    return out;
  }
};

/// A convex polygon: a triangle cut by three lines has six corners at most, plus one while rounding plays.
class Polygon {
 public:
  explicit Polygon(const std::array<Place, 3>& corners) : size_(3) { std::ranges::copy(corners, at_.begin()); }

  std::size_t size() const { return size_; }
  const Place& operator[](std::size_t i) const { return at_[i]; }

  /// Keeps what lies to the left of the line from a to b, seen from above.
  void clip(const Place& a, const Place& b) {
    std::array<Place, kMost> kept;
    std::size_t n = 0;
    for (std::size_t i = 0; i < size_ && n + 2 < kMost; ++i) {
      const Place& p = at_[i];
      const Place& q = at_[(i + 1) % size_];
      const double side_p = doubled_area(a, b, p);
      const double side_q = doubled_area(a, b, q);
      if (side_p >= 0) kept[n++] = p;
      if ((side_p > 0 && side_q < 0) || (side_p < 0 && side_q > 0)) {
        const double share = side_p / (side_p - side_q);
        kept[n++] = {p.x + share * (q.x - p.x), p.y + share * (q.y - p.y)};
      }
    }
    at_ = kept;
    size_ = n;
  }

 private:
  static constexpr std::size_t kMost = 12;
  std::array<Place, kMost> at_;
  std::size_t size_;
};

/// Triangles by the cells of a coarse grid that their boxes touch.
class FacetIndex {
 public:
  FacetIndex(const std::vector<Facet>& facets, double across) {
    per_side_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::sqrt(static_cast<double>(facets.size()) / 2)));
    scale_ = static_cast<double>(per_side_) / across;
    cells_.resize(per_side_ * per_side_);
    seen_.assign(facets.size(), 0);
    for (std::size_t i = 0; i < facets.size(); ++i)
      each_cell(facets[i], [&](std::vector<std::size_t>& cell) { cell.push_back(i); });
  }

  /// Calls visit(index) once for each facet whose box may touch this one's.
  template <typename Visit>
  void each_near(const Facet& facet, const Visit& visit) {
    ++round_;
    each_cell(facet, [&](const std::vector<std::size_t>& cell) {
      for (const std::size_t i : cell) {
        if (std::exchange(seen_[i], round_) != round_) visit(i);
      }
    });
  }

 private:
  std::size_t index(double at) const {
    return static_cast<std::size_t>(std::clamp(std::floor(at * scale_), 0.0, static_cast<double>(per_side_ - 1)));
  }
  template <typename Use>
  void each_cell(const Facet& f, const Use& use) {
    const auto [x0, x1] = std::minmax({f.at[0].x, f.at[1].x, f.at[2].x});
    const auto [y0, y1] = std::minmax({f.at[0].y, f.at[1].y, f.at[2].y});
    for (std::size_t j = index(y0); j <= index(y1); ++j) {
      for (std::size_t i = index(x0); i <= index(x1); ++i) use(cells_[j * per_side_ + i]);
    }
  }

  std::size_t per_side_ = 1;
  double scale_ = 1;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<std::uint32_t> seen_;
  std::uint32_t round_ = 0;
};

class MorphMaker {
 public:
  MorphMaker(const DrawableTile& tile, const DrawableTile& parent) : tile_(tile), parent_(parent) {
    for (const DrawVertex& v : tile.vertices) {
      wide_ = std::max(wide_, static_cast<double>(v.x()));
      high_ = std::max(high_, static_cast<double>(v.y()));
      skirted_ |= v.skirt();
    }
  }

  std::optional<MorphMesh> make() {
    if (!tile_.occluder->closed) return std::nullopt;
    const std::vector<Facet> fine = facets(tile_);
    FacetIndex near(fine, std::max(wide_, high_));
    double covered = 0;
    for (const Facet& coarse : facets(parent_)) {
      const auto [x0, x1] = std::minmax({coarse.at[0].x, coarse.at[1].x, coarse.at[2].x});
      const auto [y0, y1] = std::minmax({coarse.at[0].y, coarse.at[1].y, coarse.at[2].y});
      if (x1 <= 0 || y1 <= 0 || x0 >= wide_ || y0 >= high_) continue;
      near.each_near(coarse, [&](std::size_t i) { covered += add_overlap(fine[i], coarse); });
    }
    double all = 0;
    for (const Facet& f : fine) all += doubled_area(f.at[0], f.at[1], f.at[2]);
    if (covered < all * (1 - 1e-9)) return std::nullopt;
    out_.surface_triangles = static_cast<std::uint32_t>(out_.indices.size() / 3);
    add_skirt();
    return std::move(out_);
  }

 private:
  Place place(const DrawableTile& of, const DrawVertex& v) const {
    const double step = std::ldexp(1.0, tile_.frame.xy_shift);
    return {(of.frame.column(v.x()) - static_cast<double>(tile_.frame.column0)) / step,
            (of.frame.row(v.y()) - static_cast<double>(tile_.frame.row0)) / step};
  }

  std::vector<Facet> facets(const DrawableTile& of) const {
    std::vector<Facet> out(of.surface_triangles);
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const DrawVertex& v = of.vertices[of.index(3 * i + corner)];
        const double z_m = of.frame.height_m(v.z());
        out[i].at[corner] = place(of, v);
        out[i].value[corner] = {z_m / tile_.frame.z_step_m - static_cast<double>(tile_.frame.z_offset),
                                static_cast<double>(v.normal_x), static_cast<double>(v.normal_y)};
      }
    }
    return out;
  }

  /// Adds what two triangles have in common; returns twice its area.
  double add_overlap(const Facet& fine, const Facet& coarse) {
    Polygon polygon(fine.at);
    for (std::size_t i = 0; i < 3 && polygon.size() > 2; ++i) polygon.clip(coarse.at[i], coarse.at[(i + 1) % 3]);
    double area = 0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) area += doubled_area(polygon[0], polygon[i], polygon[i + 1]);
    if (!(area > 0)) return 0;
    std::vector<std::uint32_t>& corners = corners_;
    corners.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const std::uint32_t v = vertex(polygon[i], fine, coarse);
      if (corners.empty() || (corners.back() != v && corners.front() != v)) corners.push_back(v);
    }
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
      out_.indices.insert(out_.indices.end(), {corners[0], corners[i], corners[i + 1]});
    return area;
  }

  /// The vertex at a place: one for all polygons that meet there, so that no crack opens between them.
  std::uint32_t vertex(const Place& p, const Facet& fine, const Facet& coarse) {
    // The same corner comes out of two polygons with differences of rounding. Common corners lie on dyadic fractions,
    // so the cells' sides do not.
    constexpr double kPerStep = 1024;
    constexpr double kOffset = 0.382;
    const auto cell = [](double at) { return static_cast<std::uint64_t>(std::floor(at * kPerStep + kOffset) + 1); };
    const auto next = static_cast<std::uint32_t>(out_.vertices.size());
    const auto [at, added] = by_cell_.try_emplace(cell(p.x) << 32 | cell(p.y), next);
    if (!added) return at->second;
    const auto own = fine.sample(p);
    const auto goal = coarse.sample(p);
    const auto part = [](double v) { return static_cast<std::int16_t>(std::lround(std::clamp(v, -32767.0, 32767.0))); };
    out_.vertices.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(own[0]),
                             static_cast<float>(goal[0]), part(own[1]), part(own[2]), part(goal[1]), part(goal[2]), 0});
    return next;
  }

  /// As SkirtMaker does for the tile's own mesh.
  void add_skirt() {
    std::unordered_map<std::uint32_t, std::uint32_t> lowered;
    const auto low = [&](std::uint32_t i) {
      const auto [at, added] = lowered.try_emplace(i, static_cast<std::uint32_t>(out_.vertices.size()));
      if (added) {
        MorphVertex copy = out_.vertices[i];
        copy.skirt = sides(copy);
        out_.vertices.push_back(copy);
      }
      return at->second;
    };
    const std::size_t surface = out_.indices.size();
    for (std::size_t i = 0; i < surface; ++i) {
      const std::uint32_t a = out_.indices[i];
      const std::uint32_t b = out_.indices[i % 3 == 2 ? i - 2 : i + 1];
      if ((sides(out_.vertices[a]) & sides(out_.vertices[b])) == 0) continue;
      const std::array<std::uint32_t, 6> wall{b, a, low(a), b, low(a), low(b)};
      out_.indices.insert(out_.indices.end(), wall.begin(), wall.end());
    }
  }

  std::uint16_t sides(const MorphVertex& v) const {
    const auto on = [](float at, double side) { return std::abs(static_cast<double>(at) - side) < 1e-3; };
    const int bits = (on(v.x, 0) ? kSkirtWest : 0) | (on(v.x, wide_) ? kSkirtEast : 0) |
                     (on(v.y, 0) ? kSkirtNorth : 0) | (on(v.y, high_) ? kSkirtSouth : 0);
    return static_cast<std::uint16_t>(bits & skirted_);
  }

  const DrawableTile& tile_;
  const DrawableTile& parent_;
  double wide_ = 0;  ///< The tile's square, or what the raster leaves of it, in address steps.
  double high_ = 0;
  std::uint16_t skirted_ = 0;
  MorphMesh out_;
  std::unordered_map<std::uint64_t, std::uint32_t> by_cell_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

std::optional<MorphMesh> make_morph(const DrawableTile& tile, const DrawableTile& parent) {
  return MorphMaker(tile, parent).make();
}

}  // namespace tintree::cache
