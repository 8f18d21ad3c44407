#include "tests/simplify/support.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "cache/height_blocks.h"
#include "codec/mesh_codec.h"
#include "simplify/tree_builder.h"

namespace tintree::test {
namespace {

constexpr std::uint64_t kCacheBytes = std::uint64_t{64} << 20;

/// A polygon in the plane with few corners.
struct Polygon {
  std::array<std::array<double, 2>, 12> points{};
  std::size_t count = 0;

  void add(double x, double y) { points[count++] = {x, y}; }
  double area() const {
    double twice = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto& p = points[i];
      const auto& q = points[(i + 1) % count];
      twice += (p[0] - points[0][0]) * (q[1] - points[0][1]) - (q[0] - points[0][0]) * (p[1] - points[0][1]);
    }
    return std::abs(twice) / 2;
  }
};

/// The part where a x + b y >= c, its corners on the line exact where the line runs along an axis.
Polygon clipped(const Polygon& in, double a, double b, double c) {
  Polygon out;
  for (std::size_t i = 0; i < in.count; ++i) {
    const auto& p = in.points[i];
    const auto& q = in.points[(i + 1) % in.count];
    const double dp = a * p[0] + b * p[1] - c;
    const double dq = a * q[0] + b * q[1] - c;
    if (dp >= 0) out.add(p[0], p[1]);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
      const double t = dp / (dp - dq);
      double x = p[0] + t * (q[0] - p[0]);
      double y = p[1] + t * (q[1] - p[1]);
      if (b == 0) x = c / a;
      if (a == 0) y = c / b;
      out.add(x, y);
    }
  }
  return out;
}

struct Plane {
  Corner origin;
  double a;
  double b;

  explicit Plane(const std::array<Corner, 3>& t) : origin(t[0]) {
    const auto& [p, q, r] = t;
    const double d = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
    a = ((q[2] - p[2]) * (r[1] - p[1]) - (r[2] - p[2]) * (q[1] - p[1])) / d;
    b = ((q[0] - p[0]) * (r[2] - p[2]) - (r[0] - p[0]) * (q[2] - p[2])) / d;
  }
  double at(double x, double y) const { return origin[2] + a * (x - origin[0]) + b * (y - origin[1]); }
};

class OverlayMaker {
 public:
  OverlayMaker(const HeightGrid& grid, const codec::CellRect& square)
      : grid_(grid), square_(square), covered_(2 * cell_count(), 0), error_(sample_count(), kMissing) {}

  void add(const std::array<Corner, 3>& t) {
    const Plane plane(t);
    Polygon whole;
    for (const Corner& p : t) whole.add(p[0], p[1]);
    const auto [top, bottom] = std::minmax({t[0][1], t[1][1], t[2][1]});
    for (auto j = static_cast<std::int64_t>(std::floor(top)); static_cast<double>(j) < bottom; ++j) {
      const auto y = static_cast<double>(j);
      const Polygon strip = clipped(clipped(whole, 0, 1, y), 0, -1, -(y + 1));
      if (strip.count == 0) continue;
      double left = strip.points[0][0];
      double right = left;
      for (std::size_t k = 0; k < strip.count; ++k) {
        left = std::min(left, strip.points[k][0]);
        right = std::max(right, strip.points[k][0]);
      }
      for (auto i = static_cast<std::int64_t>(std::floor(left)); static_cast<double>(i) < right; ++i) {
        const auto x = static_cast<double>(i);
        const Polygon cell = clipped(clipped(strip, 1, 0, x), -1, 0, -(x + 1));
        add_half(plane, clipped(cell, -1, 1, y - x), i, j, false);
        add_half(plane, clipped(cell, 1, -1, x - y), i, j, true);
      }
    }
    note_samples(t, plane);
  }

  Overlay result() {
    for (std::int64_t j = square_.row0; j < square_.row1; ++j) {
      for (std::int64_t i = square_.column0; i < square_.column1; ++i) {
        check_coverage(covered_[slot(i, j)], grid_.has_lower(i, j));
        check_coverage(covered_[slot(i, j) + 1], grid_.has_upper(i, j));
      }
    }
    double sum = 0;
    for (const double e : error_) {
      if (std::isnan(e)) continue;
      sum += e * e;
      ++out_.samples;
    }
    out_.rms_m = out_.samples == 0 ? 0 : std::sqrt(sum / static_cast<double>(out_.samples));
    return out_;
  }

 private:
  std::size_t cell_count() const {
    return static_cast<std::size_t>((square_.column1 - square_.column0) * (square_.row1 - square_.row0));
  }
  std::size_t sample_count() const {
    return static_cast<std::size_t>((square_.column1 - square_.column0 + 1) * (square_.row1 - square_.row0 + 1));
  }
  std::size_t slot(std::int64_t i, std::int64_t j) const {
    return static_cast<std::size_t>(2 *
                                    ((j - square_.row0) * (square_.column1 - square_.column0) + i - square_.column0));
  }
  void check_coverage(double area, bool exists) {
    out_.coverage_error = std::max(out_.coverage_error, std::abs(area - (exists ? 0.5 : 0.0)));
  }

  void add_half(const Plane& plane, const Polygon& piece, std::int64_t i, std::int64_t j, bool upper) {
    if (piece.count == 0) return;
    const double area = piece.area();
    if (i < square_.column0 || j < square_.row0 || i >= square_.column1 || j >= square_.row1) {
      out_.coverage_error = std::max(out_.coverage_error, area);
      return;
    }
    covered_[slot(i, j) + (upper ? 1 : 0)] += area;
    if (!(upper ? grid_.has_upper(i, j) : grid_.has_lower(i, j))) return;
    const auto x = static_cast<double>(i);
    const auto y = static_cast<double>(j);
    const Corner nw{x, y, grid_.at(i, j)};
    const Corner se{x + 1, y + 1, grid_.at(i + 1, j + 1)};
    const Plane surface({nw, se, upper ? Corner{x + 1, y, grid_.at(i + 1, j)} : Corner{x, y + 1, grid_.at(i, j + 1)}});
    for (std::size_t k = 0; k < piece.count; ++k) {
      const auto [px, py] = piece.points[k];
      const double gap = std::abs(plane.at(px, py) - surface.at(px, py));
      out_.max_m = std::max(out_.max_m, gap);
      if (on_side(px, py)) out_.border_max_m = std::max(out_.border_max_m, gap);
    }
  }

  bool on_side(double x, double y) const {
    return x == static_cast<double>(square_.column0) || x == static_cast<double>(square_.column1) ||
           y == static_cast<double>(square_.row0) || y == static_cast<double>(square_.row1);
  }

  void note_samples(const std::array<Corner, 3>& t, const Plane& plane) {
    const auto [left, right] = std::minmax({t[0][0], t[1][0], t[2][0]});
    const auto [top, bottom] = std::minmax({t[0][1], t[1][1], t[2][1]});
    for (double y = std::ceil(top); y <= bottom; ++y) {
      for (double x = std::ceil(left); x <= right; ++x) {
        if (!inside(t, x, y)) continue;
        const auto i = static_cast<std::int64_t>(x);
        const auto j = static_cast<std::int64_t>(y);
        const std::int64_t at = (j - square_.row0) * (square_.column1 - square_.column0 + 1) + i - square_.column0;
        error_[static_cast<std::size_t>(at)] = plane.at(x, y) - grid_.at(i, j);
      }
    }
  }

  /// Exact: coordinates are short dyadic fractions.
  static bool inside(const std::array<Corner, 3>& t, double x, double y) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& p = t[k];
      const Corner& q = t[(k + 1) % 3];
      if ((q[0] - p[0]) * (y - p[1]) - (x - p[0]) * (q[1] - p[1]) > 0) return false;
    }
    return true;
  }

  const HeightGrid& grid_;
  codec::CellRect square_;
  std::vector<double> covered_;
  std::vector<double> error_;
  Overlay out_;
};

/// No edge has more than one triangle on a side, and the triangles at every vertex are one fan.
void expect_manifold(const codec::TileMesh& mesh) {
  // For each vertex: the corner that follows each of its neighbours around it.
  std::vector<std::map<std::uint32_t, std::uint32_t>> around(mesh.vertices.size());
  for (const codec::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_TRUE(around[t[k]].emplace(t[(k + 1) % 3], t[(k + 2) % 3]).second) << "a directed edge twice";
    }
  }
  for (const auto& following : around) {
    ASSERT_FALSE(following.empty()) << "a vertex without triangles";
    // An open fan starts at the neighbour that follows none.
    std::set<std::uint32_t> later;
    for (const auto& [from, to] : following) later.insert(to);
    std::uint32_t at = following.begin()->first;
    for (const auto& [from, to] : following) at = later.contains(from) ? at : from;
    std::size_t count = 0;
    for (auto next = following.find(at); next != following.end() && count < following.size(); ++count) {
      next = following.find(next->second);
    }
    EXPECT_EQ(count, following.size()) << "two fans at one vertex";
  }
}

using TriangleList = std::vector<std::array<std::array<std::int64_t, 3>, 3>>;

TriangleList triangle_list(const codec::TileMesh& mesh) {
  TriangleList out;
  for (const codec::Triangle& t : mesh.triangles) {
    std::array<std::array<std::int64_t, 3>, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const codec::GridVertex& v = mesh.vertices[t[k]];
      corners[k] = {v.x, v.y, mesh.z_offset + v.z};
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    out.push_back(corners);
  }
  std::ranges::sort(out);
  return out;
}

void expect_codec_keeps(const codec::TileMesh& mesh, const std::string& method) {
  const codec::MeshCodec& codec = *codec::find_codec(method);
  const auto bytes = codec.encode(mesh);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
  const auto decoded = codec.decode(*bytes);
  ASSERT_TRUE(decoded.has_value()) << decoded.error().text();
  EXPECT_EQ(decoded->xy_shift, mesh.xy_shift);
  EXPECT_EQ(triangle_list(*decoded), triangle_list(mesh));
}

Terrain terrain_of(std::shared_ptr<const cache::RasterSource> source) {
  Terrain out;
  out.grid = read_grid(*source);
  auto blocks = std::make_shared<cache::HeightBlocks>(std::move(source), kCacheBytes);
  auto surface = simplify::ReferenceSurface::scan(blocks, [](std::uint64_t, std::uint64_t) { return true; });
  if (!surface) throw std::runtime_error(surface.error().text());
  out.surface = std::move(*surface);
  return out;
}

}  // namespace

Terrain read_terrain(const std::string& path) {
  auto source = cache::RasterSource::open(path);
  if (!source) throw std::runtime_error(source.error().text());
  return terrain_of(std::make_shared<cache::RasterSource>(std::move(*source)));
}

Terrain make_terrain(int columns, int rows, const HeightFunction& height) {
  return make_exact_terrain(columns, rows, [&](int c, int r) { return std::round(height(c, r) * 64) / 64; });
}

Terrain make_exact_terrain(int columns, int rows, const HeightFunction& height) {
  static int count = 0;
  const std::string path = "/vsimem/terrain" + std::to_string(count++) + ".tif";
  write_raster(path, {.columns = columns, .rows = rows}, height);
  return read_terrain(path);
}

double relief_m(const HeightGrid& grid) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double h : grid.heights_m) {
    if (std::isnan(h)) continue;
    low = std::min(low, h);
    high = std::max(high, h);
  }
  return high > low ? high - low : 1;
}

Expected<codec::TreeLayout> plan_layout(const Terrain& terrain, int tile_cells, double leaf_error_m,
                                        int levels_per_doubling) {
  const cache::RasterInfo& info = terrain.surface->blocks().source().info();
  codec::TreeLayout layout;
  layout.columns = terrain.grid.columns;
  layout.rows = terrain.grid.rows;
  layout.tile_cells = tile_cells;
  layout.levels_per_doubling = levels_per_doubling;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(layout.columns, layout.rows, tile_cells, levels_per_doubling);
  layout.dx_m = info.dx_m;
  layout.dy_m = info.dy_m;
  layout.leaf_error_m = leaf_error_m;
  auto steps = simplify::choose_height_steps(*terrain.surface, layout);
  if (!steps) return tl::unexpected(steps.error());
  layout.z_step_m = std::move(*steps);
  return layout;
}

codec::TreeLayout make_layout(const Terrain& terrain, int tile_cells, double leaf_error_m, int levels_per_doubling) {
  auto layout = plan_layout(terrain, tile_cells, leaf_error_m, levels_per_doubling);
  if (!layout) throw std::runtime_error(layout.error().text());
  return std::move(*layout);
}

std::vector<codec::TileId> tiles_of(const codec::TreeLayout& layout) {
  std::vector<codec::TileId> out;
  for (int level = 0; level <= layout.leaf_level; ++level) {
    for (std::uint32_t y = 0; y < layout.tiles_y(level); ++y) {
      for (std::uint32_t x = 0; x < layout.tiles_x(level); ++x) out.push_back({level, x, y});
    }
  }
  return out;
}

Overlay overlay(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                const codec::TileMesh& mesh) {
  const codec::GridFrame frame(layout, id, mesh);
  const std::int64_t across = layout.cells_across(id.level);
  OverlayMaker maker(grid, {frame.column0, frame.row0, frame.column0 + across, frame.row0 + across});
  for (const codec::Triangle& t : mesh.triangles) {
    std::array<Corner, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const codec::GridVertex& v = mesh.vertices[t[k]];
      corners[k] = {frame.column(v.x), frame.row(v.y), frame.height_m(v.z)};
    }
    maker.add(corners);
  }
  return maker.result();
}

std::int64_t half_cells(const HeightGrid& grid, const codec::CellRect& cells) {
  std::int64_t count = 0;
  for (std::int64_t j = cells.row0; j < cells.row1; ++j) {
    for (std::int64_t i = cells.column0; i < cells.column1; ++i) {
      count += (grid.has_lower(i, j) ? 1 : 0) + (grid.has_upper(i, j) ? 1 : 0);
    }
  }
  return count;
}

void expect_sound_mesh(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                       const codec::TileMesh& mesh) {
  const auto valid = codec::validate(mesh, layout.cells_across(id.level));
  ASSERT_TRUE(valid.has_value()) << valid.error().text();
  expect_manifold(mesh);
  double area = 0;
  for (const codec::Triangle& t : mesh.triangles) {
    area += static_cast<double>(codec::doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
  EXPECT_EQ(std::ldexp(area, 2 * mesh.xy_shift), static_cast<double>(half_cells(grid, layout.cells(id))));
}

void expect_sound_tile(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                       const codec::TileMesh& mesh, const std::string& method) {
  SCOPED_TRACE("tile " + id.text());
  if (half_cells(grid, layout.cells(id)) == 0) {
    EXPECT_TRUE(mesh.triangles.empty());
    return;
  }
  expect_sound_mesh(grid, layout, id, mesh);
  expect_codec_keeps(mesh, method);
  if (testing::Test::HasFatalFailure()) return;
  const Overlay found = overlay(grid, layout, id, mesh);
  EXPECT_LE(found.coverage_error, 1e-9);
  EXPECT_LE(found.max_m, layout.bound_m(id.level) * (1 + 1e-12));
}

}  // namespace tintree::test
