#include "codec/nested_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "codec/nested_payload.h"
#include "codec/nested_tile.h"
#include "codec/nested_points.h"
#include "codec/split_fans.h"

namespace tintree::codec {
namespace {

tl::unexpected<Error> not_nested() {
  return fail(ErrorCode::kBadData, "the mesh is not one of nested right triangles");
}

/// A sum over triangles that does not depend on their order or on which corner comes first.
class TriangleSum {
 public:
  void add(const GridVertex& a, const GridVertex& b, const GridVertex& c) {
    sum_ += mix(mix(a) + 3 * mix(b)) + mix(mix(b) + 3 * mix(c)) + mix(mix(c) + 3 * mix(a));
    ++count_;
  }
  friend bool operator==(const TriangleSum&, const TriangleSum&) = default;

 private:
  static std::uint64_t mix(std::uint64_t v) {
    v = (v ^ v >> 32) * 0xd6e8feb86659fd93U;
    return v ^ v >> 29;
  }
  static std::uint64_t mix(const GridVertex& v) {
    return mix(static_cast<std::uint64_t>(v.x) << 40 ^ static_cast<std::uint64_t>(v.y) << 22 ^
               static_cast<std::uint64_t>(v.z));
  }
  std::uint64_t sum_ = 0;
  std::uint64_t count_ = 0;
};

GridVertex vertex(const NestedPoint& p) { return {p.x, p.y, p.z}; }

bool same_triangles(const TileMesh& mesh, const NestedPoints& points) {
  TriangleSum given;
  for (const Triangle& t : mesh.triangles) given.add(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
  TriangleSum made;
  points.for_each_triangle(NestedTile::kMostLevels, [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    made.add(vertex(points.point(a)), vertex(points.point(b)), vertex(points.point(c)));
  });
  return given == made;
}

/// The side of the tile in address steps as digits; the points that are always there tell.
int side_bits_of(const TileMesh& mesh) {
  std::int32_t side = 1;
  for (const GridVertex& v : mesh.vertices) side = std::max({side, v.x, v.y});
  for (const NestedGap& g : mesh.nested_gaps) side = std::max({side, g.x, g.y});
  return std::countr_zero(std::bit_ceil(static_cast<std::uint32_t>(side)));
}

}  // namespace

Expected<std::vector<std::byte>> NestedMesh::encode(const TileMesh& mesh) const {
  if (mesh.nested_levels.empty() || mesh.nested_levels.size() > mesh.vertices.size()) return not_nested();
  const int side_bits = side_bits_of(mesh);
  if (side_bits > NestedPoints::kMostSideBits)
    return fail(ErrorCode::kBadData, "the tile is too wide for method nested; choose a larger --error or --tile");
  NestedPoints points(side_bits);
  const auto add = [&](const NestedPoint& p) {
    const bool fits = p.x >= 0 && p.y >= 0 && p.x <= points.side() && p.y <= points.side() &&
                      points.find(p.x, p.y) == NestedPoints::kNone && p.level < NestedTile::kMostLevels;
    if (fits) points.add(p);
    return fits;
  };
  for (std::size_t i = 0; i < mesh.nested_levels.size(); ++i) {
    const GridVertex& v = mesh.vertices[i];
    if (!add({v.x, v.y, v.z, mesh.nested_levels[i], false})) return not_nested();
  }
  for (const NestedGap& g : mesh.nested_gaps) {
    if (!add({g.x, g.y, 0, g.level, true})) return not_nested();
  }
  NestedPoints written(side_bits);
  auto bytes = write_nested(mesh.xy_shift, mesh.z_offset, side_bits, NestedTile::kMostLevels, points, written);
  if (bytes && !same_triangles(mesh, written)) return not_nested();
  return bytes;
}

Expected<TileMesh> NestedMesh::decode(std::span<const std::byte> bytes) const {
  const auto payload = parse_nested(bytes, NestedTile::kMostLevels);
  if (!payload) return tl::unexpected(payload.error());
  const auto points = read_points(*payload, NestedTile::kMostLevels);
  if (!points) return tl::unexpected(points.error());
  TileMesh mesh = finest_mesh(*points);
  mesh.xy_shift = payload->xy_shift;
  mesh.z_offset = payload->z_offset;
  return mesh;
}

TileMesh finest_mesh(const NestedPoints& points) {
  constexpr std::uint32_t kUnused = UINT32_MAX;
  TileMesh mesh;
  std::vector<std::uint32_t> number(points.points().size(), kUnused);
  const auto number_of = [&](std::int32_t i) {
    std::uint32_t& n = number[static_cast<std::size_t>(i)];
    if (n == kUnused) {
      n = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(vertex(points.point(i)));
      mesh.nested_levels.push_back(points.point(i).level);
    }
    return n;
  };
  points.for_each_triangle(NestedTile::kMostLevels, [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    mesh.triangles.push_back({number_of(a), number_of(b), number_of(c)});
  });
  for (std::size_t i = 0; i < number.size(); ++i) {
    const NestedPoint& p = points.points()[i];
    if (number[i] == kUnused) mesh.nested_gaps.push_back({p.x, p.y, p.level});
  }
  if (!mesh.nested_gaps.empty()) split_fans(mesh);
  return mesh;
}

}  // namespace tintree::codec
