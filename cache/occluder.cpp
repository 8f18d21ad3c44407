#include "cache/occluder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tintree::cache {
namespace {

constexpr std::size_t kStrips = Occluder::kStrips;
constexpr std::size_t kLines = Occluder::kLines;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A point of the mesh: strips across, strips down, metres up.
struct Point {
  double u = 0;
  double v = 0;
  double z = 0;
};
using Corners = std::array<Point, 3>;

/// Rounds towards minus infinity.
float down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float up(double v) { return -down(-v); }

double& along(Point& p, bool row) { return row ? p.u : p.v; }
double across(const Point& p, bool row) { return row ? p.v : p.u; }

std::size_t strip(double at) {
  return static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, static_cast<double>(kStrips - 1)));
}

/// Calls piece(line, a, b) for each part of a triangle that lies on a line: `row` lines are those of constant v.
template <typename Piece>
void cut(const Corners& corners, bool row, const Piece& piece) {
  const auto [low, high] = std::minmax({across(corners[0], row), across(corners[1], row), across(corners[2], row)});
  const double last = std::min(std::floor(high), static_cast<double>(kStrips));
  for (double line = std::max(std::ceil(low), 0.0); line <= last; ++line) {
    Point a{kInfinity, kInfinity, 0}, b{-kInfinity, -kInfinity, 0};
    const auto meet = [&](Point p) {
      if (along(p, row) < along(a, row)) a = p;
      if (along(p, row) > along(b, row)) b = p;
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const Point& p = corners[i];
      const Point& q = corners[(i + 1) % 3];
      const double from_p = line - across(p, row);
      const double from_q = line - across(q, row);
      if (from_p == 0) meet(p);
      if (from_p * from_q >= 0) continue;
      const double share = from_p / (from_p - from_q);
      meet({p.u + share * (q.u - p.u), p.v + share * (q.v - p.v), p.z + share * (q.z - p.z)});
    }
    if (along(a, row) <= along(b, row)) piece(static_cast<std::size_t>(line), a, b);
  }
}

class OccluderMaker {
 public:
  OccluderMaker(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh)
      : mesh_(mesh), frame_(layout, id, mesh) {
    out_.cells = layout.cells(id);
    width_ = static_cast<double>(out_.cells.column1 - out_.cells.column0) / static_cast<double>(kStrips);
    height_ = static_cast<double>(out_.cells.row1 - out_.cells.row0) / static_cast<double>(kStrips);
  }

  Occluder make() {
    out_.closed = covers_all();
    if (!out_.closed) return std::move(out_);
    out_.row_lines = lines(true);
    out_.column_lines = lines(false);
    make_planes();
    return std::move(out_);
  }

 private:
  Corners corners(const codec::Triangle& t) const {
    Corners out;
    for (std::size_t i = 0; i < 3; ++i) {
      const codec::GridVertex& p = mesh_.vertices[t[i]];
      out[i] = {(frame_.column(p.x) - static_cast<double>(out_.cells.column0)) / width_,
                (frame_.row(p.y) - static_cast<double>(out_.cells.row0)) / height_, frame_.height_m(p.z)};
    }
    return out;
  }

  /// The triangles do not overlap, so that they leave no hole where their areas add up to the tile's. Exact:
  /// addresses are dyadic.
  bool covers_all() const {
    std::int64_t doubled = 0;
    for (const codec::Triangle& t : mesh_.triangles)
      doubled += codec::doubled_area(mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]);
    const codec::CellRect& c = out_.cells;
    const auto cells = static_cast<double>((c.column1 - c.column0) * (c.row1 - c.row0));
    return std::ldexp(static_cast<double>(doubled), 2 * mesh_.xy_shift) == 2 * cells;
  }

  std::vector<Occluder::Line> lines(bool row) const {
    using Heights = std::array<double, kLines>;
    std::vector<Heights> at(kLines, Heights{});
    const auto each = [&](const auto& piece) {
      for (const codec::Triangle& t : mesh_.triangles) cut(corners(t), row, piece);
    };
    each([&](std::size_t line, Point a, Point b) {
      const double span = along(b, row) - along(a, row);
      for (double i = std::max(std::ceil(along(a, row)), 0.0); i <= along(b, row) && i < kLines; ++i) {
        const double share = span > 0 ? (i - along(a, row)) / span : 0;
        at[line][static_cast<std::size_t>(i)] = a.z + share * (b.z - a.z);
      }
    });
    // How far each part of a line must be lowered.
    std::vector<Heights> drop(kLines, Heights{});
    each([&](std::size_t line, Point a, Point b) {
      for (Point p : {a, b}) {
        const std::size_t i = strip(along(p, row));
        const double share = along(p, row) - static_cast<double>(i);
        const double straight = at[line][i] + share * (at[line][i + 1] - at[line][i]);
        drop[line][i] = std::max(drop[line][i], straight - p.z);
      }
    });
    std::vector<Occluder::Line> out(kLines);
    for (std::size_t line = 0; line < kLines; ++line) {
      for (std::size_t i = 0; i < kLines; ++i) {
        const double least = std::max(i < kStrips ? drop[line][i] : 0, i > 0 ? drop[line][i - 1] : 0);
        out[line][i] = down(at[line][i] - least);
      }
    }
    return out;
  }

  /// Each cell's plane leans as the lines at its corners do and is lifted above every corner of the surface's
  /// overlay with the cells.
  void make_planes() {
    out_.planes.resize(kStrips * kStrips);
    for (std::size_t j = 0; j < kStrips; ++j) {
      for (std::size_t i = 0; i < kStrips; ++i) {
        const auto corner = [&](std::size_t di, std::size_t dj) { return out_.row_lines[j + dj][i + di]; };
        out_.planes[j * kStrips + i] = {-std::numeric_limits<float>::infinity(),
                                        (corner(1, 0) - corner(0, 0) + corner(1, 1) - corner(0, 1)) / 2,
                                        (corner(0, 1) - corner(0, 0) + corner(1, 1) - corner(1, 0)) / 2};
      }
    }
    for (const codec::Triangle& t : mesh_.triangles) {
      const Corners c = corners(t);
      for (const Point& p : c) lift(p);
      // The ends of the pieces within each cell: where the triangle's edges meet lines, and where lines meet.
      for (const bool row : {true, false}) {
        cut(c, row, [&](std::size_t, Point a, Point b) {
          lift(a), lift(b);
          const double span = along(b, row) - along(a, row);
          for (double i = std::ceil(along(a, row)); span > 0 && i <= along(b, row); ++i) {
            const double share = (i - along(a, row)) / span;
            lift({a.u + share * (b.u - a.u), a.v + share * (b.v - a.v), a.z + share * (b.z - a.z)});
          }
        });
      }
    }
  }

  /// Lifts the planes of the cells that a point lies in or on the side of.
  void lift(const Point& p) {
    constexpr double kNear = 1e-9;  // Crossings are rounded.
    for (std::size_t j = strip(p.v - kNear); j <= strip(p.v + kNear); ++j) {
      for (std::size_t i = strip(p.u - kNear); i <= strip(p.u + kNear); ++i) {
        Occluder::Plane& plane = out_.planes[j * kStrips + i];
        const double leaning = (p.u - static_cast<double>(i)) * static_cast<double>(plane.rise_u_m) +
                               (p.v - static_cast<double>(j)) * static_cast<double>(plane.rise_v_m);
        plane.z_m = std::max(plane.z_m, up(p.z - leaning));
      }
    }
  }

  const codec::TileMesh& mesh_;
  codec::GridFrame frame_;
  double width_ = 1;  ///< Of a strip, in DEM cells.
  double height_ = 1;
  Occluder out_;
};

}  // namespace

double Occluder::top_m(double column, double row) const {
  if (!closed) return kInfinity;
  const double u = (column - static_cast<double>(cells.column0)) * static_cast<double>(kStrips) /
                   static_cast<double>(cells.column1 - cells.column0);
  const double v = (row - static_cast<double>(cells.row0)) * static_cast<double>(kStrips) /
                   static_cast<double>(cells.row1 - cells.row0);
  const std::size_t i = strip(u);
  const std::size_t j = strip(v);
  const Plane& plane = planes[j * kStrips + i];
  return static_cast<double>(plane.z_m) + (u - static_cast<double>(i)) * static_cast<double>(plane.rise_u_m) +
         (v - static_cast<double>(j)) * static_cast<double>(plane.rise_v_m);
}

std::size_t Occluder::bytes() const {
  return (row_lines.size() + column_lines.size()) * sizeof(Line) + planes.size() * sizeof(Plane);
}

Occluder make_occluder(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh) {
  return OccluderMaker(layout, id, mesh).make();
}

}  // namespace tintree::cache
