#include "codec/tile_mesh.h"

#include <algorithm>
#include <string>

namespace tintree::codec {

Expected<void> validate(const TileMesh& mesh, std::int64_t cells) {
  if (mesh.xy_shift < kMinXyShift || mesh.xy_shift > kMaxXyShift) {
    return fail(ErrorCode::kBadData, "the address step is out of range");
  }
  if (mesh.z_offset < -kMaxHeightOffset || mesh.z_offset > kMaxHeightOffset) {
    return fail(ErrorCode::kBadData, "the height origin is out of range");
  }
  const std::int64_t span = mesh.xy_shift >= 0 ? cells >> mesh.xy_shift : cells << -mesh.xy_shift;
  for (const GridVertex& v : mesh.vertices) {
    if (v.x < 0 || v.y < 0 || v.x > span || v.y > span || v.z < 0 || v.z > kMaxHeightAddress) {
      return fail(ErrorCode::kBadData, "a vertex lies outside its tile");
    }
  }
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    if (std::ranges::any_of(t, [count](std::uint32_t i) { return i >= count; })) {
      return fail(ErrorCode::kBadData, "a triangle names a vertex that is not there");
    }
    if (doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]) <= 0) {
      return fail(ErrorCode::kBadData, "a triangle is flipped or degenerate");
    }
  }
  return {};
}

}  // namespace tintree::codec
