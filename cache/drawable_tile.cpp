#include "cache/drawable_tile.h"

#include <array>
#include <cmath>
#include <unordered_map>

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

DrawVertex draw_vertex(const codec::GridVertex& v, const Vector& normal_sum) {
  const double length = std::sqrt(dot(normal_sum, normal_sum));
  const double scale = length > 0 ? 1 / length : 0;
  return {static_cast<float>(v.x),         static_cast<float>(v.y),        static_cast<float>(v.z), 0,
          to_snorm(normal_sum[0] * scale), to_snorm(normal_sum[1] * scale)};
}

/// Adds the skirt to a tile that holds its surface.
class SkirtMaker {
 public:
  SkirtMaker(const codec::TreeLayout& layout, const codec::TileMesh& mesh, DrawableTile& tile)
      : mesh_(mesh), tile_(tile) {
    const codec::CellRect cells = layout.cells(tile.id);
    const std::int64_t across = layout.cells_across(tile.id.level);
    span_ = mesh.xy_shift >= 0 ? across >> mesh.xy_shift : across << -mesh.xy_shift;
    has_west_ = tile.id.x > 0;
    has_north_ = tile.id.y > 0;
    has_east_ = cells.column1 < layout.columns - 1;
    has_south_ = cells.row1 < layout.rows - 1;
  }

  void add() {
    for (const codec::Triangle& t : mesh_.triangles) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t a = t[corner];
        const std::uint32_t b = t[(corner + 1) % 3];
        if ((sides(a) & sides(b)) != 0) add_edge(a, b);
      }
    }
  }

 private:
  std::uint16_t sides(std::uint32_t i) const {
    const codec::GridVertex& v = mesh_.vertices[i];
    return static_cast<std::uint16_t>(
        (has_west_ && v.x == 0 ? kSkirtWest : 0) | (has_east_ && v.x == span_ ? kSkirtEast : 0) |
        (has_north_ && v.y == 0 ? kSkirtNorth : 0) | (has_south_ && v.y == span_ ? kSkirtSouth : 0));
  }

  void add_edge(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low_a = lowered(a);
    const std::uint32_t low_b = lowered(b);
    for (const std::uint32_t i : {b, a, low_a, b, low_a, low_b}) tile_.indices.push_back(i);
  }

  std::uint32_t lowered(std::uint32_t i) {
    const auto next = static_cast<std::uint32_t>(tile_.vertices.size());
    const auto [at, added] = lowered_.try_emplace(i, next);
    if (added) {
      DrawVertex copy = tile_.vertices[i];
      copy.skirt = sides(i);
      tile_.vertices.push_back(copy);
    }
    return at->second;
  }

  const codec::TileMesh& mesh_;
  DrawableTile& tile_;
  std::int64_t span_ = 0;
  bool has_west_ = false, has_north_ = false, has_east_ = false, has_south_ = false;
  std::unordered_map<std::uint32_t, std::uint32_t> lowered_;
};

}  // namespace

DrawableTile make_drawable(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh) {
  DrawableTile tile;
  tile.id = id;
  tile.frame = codec::GridFrame(layout, id, mesh);
  const std::vector<Vector> sums = normal_sums(tile.frame, mesh);
  tile.vertices.reserve(mesh.vertices.size() + mesh.vertices.size() / 8);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    tile.vertices.push_back(draw_vertex(mesh.vertices[i], sums[i]));
  tile.indices.reserve(3 * mesh.triangles.size() + 3 * mesh.triangles.size() / 8);
  for (const codec::Triangle& t : mesh.triangles) tile.indices.insert(tile.indices.end(), t.begin(), t.end());
  tile.surface_triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  SkirtMaker(layout, mesh, tile).add();
  tile.occluder = std::make_shared<const Occluder>(make_occluder(layout, id, mesh));
  return tile;
}

}  // namespace tintree::cache
