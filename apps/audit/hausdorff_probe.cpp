#include "apps/audit/hausdorff_probe.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "apps/audit/hausdorff.h"

namespace tintree::audit {
namespace {

/// CGAL's error bound as a share of the vertical maximum.
constexpr double kErrorShare = 0.05;
/// And at least as a share of the window's side: CGAL cuts parallel surfaces into pieces of this size.
constexpr double kSideShare = 1.0 / 500;
constexpr std::int64_t kFewestCells = 8;
constexpr int kTries = 4;

/// Keeps the part of a convex polygon where `axis` times `sign` is at least `limit` times `sign`.
std::vector<Point> clip(const std::vector<Point>& polygon, std::size_t axis, double limit, double sign) {
  std::vector<Point> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& p = polygon[i];
    const Point& q = polygon[(i + 1) % polygon.size()];
    const double dp = (p[axis] - limit) * sign;
    const double dq = (q[axis] - limit) * sign;
    if (dp >= 0) out.push_back(p);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
      const double t = dp / (dp - dq);
      Point cut{p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])};
      cut[axis] = limit;
      out.push_back(cut);
    }
  }
  return out;
}

/// The mesh over the window, in tile-local samples and metres of height.
TriangleSoup mesh_soup(const TileSurface& s, const codec::CellRect& w) {
  TriangleSoup soup;
  const auto point = [&s](std::uint32_t v) {
    const Corner& p = s.corners[v];
    return Point{static_cast<double>(p.x) / s.units, static_cast<double>(p.y) / s.units, p.z_m};
  };
  for (const codec::Triangle& t : s.triangles) {
    std::vector<Point> polygon{point(t[0]), point(t[1]), point(t[2])};
    polygon = clip(polygon, 0, static_cast<double>(w.column0), 1);
    polygon = clip(polygon, 0, static_cast<double>(w.column1), -1);
    polygon = clip(polygon, 1, static_cast<double>(w.row0), 1);
    polygon = clip(polygon, 1, static_cast<double>(w.row1), -1);
    for (std::size_t i = 2; i < polygon.size(); ++i) soup.push_back({polygon[0], polygon[i - 1], polygon[i]});
  }
  return soup;
}

TriangleSoup reference_soup(const HeightWindow& window) {
  TriangleSoup soup;
  const codec::CellRect& w = window.cells();
  const auto point = [&window](std::int64_t c, std::int64_t r) {
    return Point{static_cast<double>(c), static_cast<double>(r), window.at(c, r)};
  };
  std::vector<std::uint8_t> triangles;
  for (std::int64_t r = w.row0; r < w.row1; ++r) {
    window.triangles_of_row(r, triangles);
    for (std::int64_t c = w.column0; c < w.column1; ++c) {
      const std::uint8_t here = triangles[static_cast<std::size_t>(c - w.column0 + 1)];
      if ((here & kLower) != 0) soup.push_back({point(c, r), point(c, r + 1), point(c + 1, r + 1)});
      if ((here & kUpper) != 0) soup.push_back({point(c, r), point(c + 1, r + 1), point(c + 1, r)});
    }
  }
  return soup;
}

void drop_slivers(TriangleSoup& soup) {
  // Cutting leaves triangles without area, which CGAL does not take.
  std::erase_if(soup, [](const std::array<Point, 3>& t) {
    const double area = (t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[1][1] - t[0][1]) * (t[2][0] - t[0][0]);
    return std::abs(area) < 1e-9;
  });
}

void to_metres(TriangleSoup& soup, const codec::TreeLayout& layout) {
  for (auto& t : soup) {
    for (Point& p : t) {
      const auto [x, y] = layout.world(p[0], p[1]);
      p = {x, y, p[2]};
    }
  }
}

/// Cells along a window's side: as many as let CGAL resolve the level's bound.
std::int64_t probe_cells(const codec::TreeLayout& layout, int level) {
  const double cells = static_cast<double>(kProbeCells) * layout.bound_m(level) / std::max(layout.dx_m, layout.dy_m);
  return static_cast<std::int64_t>(std::clamp<double>(cells, kFewestCells, kProbeCells));
}

codec::CellRect choose_window(const codec::CellRect& tile, std::int64_t side, std::mt19937_64& random) {
  const auto place = [&random, side](std::int64_t cells) {
    const std::int64_t room = std::max<std::int64_t>(cells - side, 0);
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(room + 1));
  };
  const std::int64_t width = tile.column1 - tile.column0;
  const std::int64_t height = tile.row1 - tile.row0;
  const std::int64_t c = place(width);
  const std::int64_t r = place(height);
  return {c, r, std::min(c + side, width), std::min(r + side, height)};
}

/// The exact vertical maximum over the window: all parts of the mesh are offered, those in it count.
double vertical_max(const TileSurface& s, const HeightWindow& window) {
  std::vector<std::uint32_t> triangles(s.triangles.size());
  std::vector<std::uint32_t> edges(s.edges.size());
  std::iota(triangles.begin(), triangles.end(), 0U);
  std::iota(edges.begin(), edges.end(), 0U);
  std::vector<std::uint32_t> corners;
  const codec::CellRect& w = window.cells();
  for (std::uint32_t v = 0; v < s.corners.size(); ++v) {
    const Corner& p = s.corners[v];
    const bool inside =
        p.x >= w.column0 * s.units && p.x <= w.column1 * s.units && p.y >= w.row0 * s.units && p.y <= w.row1 * s.units;
    if (inside) corners.push_back(v);
  }
  return VerticalMeasure().measure(s, window, {triangles, edges, corners, true}).overall.value_m;
}

}  // namespace

Expected<std::optional<HausdorffReport>> probe_tile(const AuditContext& context, const codec::TileId& id,
                                                    std::uint64_t seed) {
  auto mesh = context.store.read_mesh(id);
  // A tile that cannot be read has been reported already.
  if (!mesh) return std::nullopt;
  const codec::TreeLayout& layout = context.store.manifest().layout;
  const TileSurface surface = place(layout, id, std::move(*mesh));
  std::mt19937_64 random(seed);
  HeightWindow window;
  const std::int64_t side = probe_cells(layout, id.level);
  const double side_m = static_cast<double>(side) * std::max(layout.dx_m, layout.dy_m);
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const codec::CellRect local = choose_window(surface.cells, side, random);
    if (auto read = window.read(context.source, surface.cells, local); !read) return tl::unexpected(read.error());
    TriangleSoup reference = reference_soup(window);
    TriangleSoup mine = mesh_soup(surface, local);
    drop_slivers(mine);
    if (reference.empty() || mine.empty()) continue;
    to_metres(reference, layout);
    to_metres(mine, layout);
    HausdorffReport report;
    report.tile = id;
    report.cells = {surface.cells.column0 + local.column0, surface.cells.row0 + local.row0,
                    surface.cells.column0 + local.column1, surface.cells.row0 + local.row1};
    report.vertical_max_m = vertical_max(surface, window);
    report.error_bound_m = std::max(kErrorShare * report.vertical_max_m, kSideShare * side_m);
    report.hausdorff_m = symmetric_hausdorff(mine, reference, report.error_bound_m);
    return report;
  }
  return std::nullopt;
}

}  // namespace tintree::audit
