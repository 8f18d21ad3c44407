#include "cache/drawable_tile.h"

#include <array>
#include <cmath>
#include <utility>

#include "cache/skirt.h"

namespace tintree::cache {
namespace {

using Vector = std::array<double, 3>;

Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Sums, per vertex, the triangles' normals with Max's weights: the cross product of the two edges at the
/// corner over the product of their squared lengths.
std::vector<Vector> normal_sums(const codec::GridFrame& frame, const codec::TileMesh& mesh) {
  const double step = std::ldexp(1.0, frame.xy_shift);
  const auto metres = [&](std::uint32_t i) -> Vector {
    const codec::GridVertex& v = mesh.vertices[i];
    const auto [x, y] = frame.axes.world(v.x * step * frame.dx_m, v.y * step * frame.dy_m);
    return {x, y, v.z * frame.z_step_m};
  };
  std::vector<Vector> sums(mesh.vertices.size(), Vector{});
  for (const codec::Triangle& t : mesh.triangles) {
    const std::array<Vector, 3> p{metres(t[0]), metres(t[1]), metres(t[2])};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vector a = minus(p[(corner + 1) % 3], p[corner]);
      const Vector b = minus(p[(corner + 2) % 3], p[corner]);
      const Vector n = cross(a, b);
      const double weight = 1 / (dot(a, a) * dot(b, b));
      for (std::size_t axis = 0; axis < 3; ++axis) sums[t[corner]][axis] += weight * n[axis];
    }
  }
  return sums;
}

std::int16_t to_snorm(double v) { return static_cast<std::int16_t>(std::lround(v * 32767)); }

/// `drop`: the lower bits of x and y that are rounded away.
DrawVertex draw_vertex(const codec::GridVertex& v, int drop, const Vector& normal_sum) {
  const double length = std::sqrt(dot(normal_sum, normal_sum));
  const double scale = length > 0 ? 1 / length : 0;
  const auto rounded = [drop](std::int32_t a) { return (a + (1 << drop >> 1)) >> drop; };
  DrawVertex out = DrawVertex::pack(rounded(v.x), rounded(v.y), v.z);
  out.normal_x = to_snorm(normal_sum[0] * scale);
  out.normal_y = to_snorm(normal_sum[1] * scale);
  return out;
}

/// Address steps along a tile's side.
std::int64_t steps_across(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh) {
  const std::int64_t cells = layout.cells_across(id.level);
  return mesh.xy_shift >= 0 ? cells >> mesh.xy_shift : cells << -mesh.xy_shift;
}

}  // namespace

TileOutline tile_outline(const codec::TreeLayout& layout, const codec::TileId& id, int xy_shift,
                         std::uint16_t joined_sides) {
  const codec::CellRect cells = layout.cells(id);
  const auto steps = [xy_shift](std::int64_t count) { return xy_shift >= 0 ? count >> xy_shift : count << -xy_shift; };
  const int inner = (id.x > 0 ? kSkirtWest : 0) | (cells.column1 < layout.columns - 1 ? kSkirtEast : 0) |
                    (id.y > 0 ? kSkirtNorth : 0) | (cells.row1 < layout.rows - 1 ? kSkirtSouth : 0);
  return {static_cast<std::uint16_t>(inner | joined_sides), steps(cells.column1 - cells.column0),
          steps(cells.row1 - cells.row0)};
}

DrawVertex DrawVertex::pack(std::int32_t x, std::int32_t y, std::int32_t z) {
  DrawVertex out;
  out.x_low = static_cast<std::uint16_t>(x & 0xFFFF);
  out.y_low = static_cast<std::uint16_t>(y & 0xFFFF);
  out.z_low = static_cast<std::uint16_t>(z & 0xFFFF);
  out.high = static_cast<std::uint16_t>(x >> 16 << 4 | y >> 16 << 7 | z >> 16 << 10);
  return out;
}

void DrawableTile::set_indices(std::vector<std::uint32_t> all, std::size_t vertex_count) {
  if (vertex_count > 0x10000) {
    wide_indices = std::move(all);
    return;
  }
  indices.reserve(all.size());
  for (const std::uint32_t i : all) indices.push_back(static_cast<std::uint16_t>(i));
}

DrawableTile make_drawable(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                           std::uint16_t joined_sides) {
  DrawableTile tile;
  tile.id = id;
  tile.frame = codec::GridFrame(layout, id, mesh);
  const std::vector<Vector> sums = normal_sums(tile.frame, mesh);
  int drop = 0;
  while ((steps_across(layout, id, mesh) >> drop) > DrawVertex::kMostXy) ++drop;
  tile.frame.xy_shift += drop;
  tile.vertices.reserve(mesh.vertices.size() + mesh.vertices.size() / 8);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    tile.vertices.push_back(draw_vertex(mesh.vertices[i], drop, sums[i]));
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size() + 3 * mesh.triangles.size() / 8);
  for (const codec::Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  tile.surface_triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  const auto lower = [&](std::uint32_t i, std::uint16_t sides) {
    DrawVertex copy = tile.vertices[i];
    copy.high = static_cast<std::uint16_t>(copy.high | sides);
    tile.vertices.push_back(copy);
    return static_cast<std::uint32_t>(tile.vertices.size() - 1);
  };
  add_skirts(mesh, tile_outline(layout, id, mesh.xy_shift, joined_sides), lower, indices);
  tile.set_indices(std::move(indices), tile.vertices.size());
  tile.occluder = std::make_shared<const Occluder>(make_occluder(layout, id, mesh));
  return tile;
}

}  // namespace tintree::cache
