#include "codec/strip_source.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <optional>
#include <utility>

namespace tintree::codec {
namespace {

/// The tree that a mesh is part of. A mesh that ends inside its tile may fit into a smaller square or not; and a hole
/// in the finest squares may need a point that the mesh has none of.
std::optional<StripTree> find_tree(const TileMesh& mesh) {
  std::int32_t farthest = 1;
  for (const GridVertex& v : mesh.vertices) {
    if (v.x < 0 || v.y < 0) return std::nullopt;
    farthest = std::max({farthest, v.x, v.y});
  }
  const int levels = std::max(1, static_cast<int>(std::bit_width(static_cast<std::uint32_t>(farthest) - 1)));
  for (const int wider : {0, 1}) {
    for (const int fine : {0, 1}) {
      if (levels + wider + fine > kMaxStripLevels) continue;
      if (auto tree = StripTree::find(mesh, levels + wider + fine, fine)) return tree;
    }
  }
  return std::nullopt;
}

}  // namespace

StripEdge edge_between(const SplitPoint& v1, const SplitPoint& v2) {
  const std::int64_t dx = v2.x - v1.x;
  const std::int64_t dy = v2.y - v1.y;
  const auto sign = [](std::int64_t d) { return d < 0 ? -1 : d > 0 ? 1 : 0; };
  StripEdge edge;
  while (kStripX[static_cast<std::size_t>(edge.direction)] != sign(dx) ||
         kStripY[static_cast<std::size_t>(edge.direction)] != sign(dy)) {
    ++edge.direction;
  }
  edge.size = std::countr_zero(static_cast<std::uint64_t>(std::max(std::abs(dx), std::abs(dy))));
  return edge;
}

Expected<StripSource> find_strip(const TileMesh& mesh) {
  if (mesh.triangles.empty() || mesh.triangles.size() > kMaxTileTriangles / 2)
    return fail(ErrorCode::kBadData, "the tile has no triangles, or more than the format allows");
  auto tree = find_tree(mesh);
  if (!tree) return fail(ErrorCode::kBadData, "the mesh is no restricted quadtree mesh, or one too fine for a strip");
  StripHead p;
  p.xy_shift = mesh.xy_shift;
  p.levels = tree->levels();
  p.fine = tree->fine();
  p.holes = tree->holes();
  p.triangles = tree->triangles();
  std::int32_t lowest = kMaxHeightAddress;
  std::int32_t highest = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) lowest = std::min(lowest, mesh.vertices[i].z);
  }
  std::uint32_t bits = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      highest = std::max(highest, mesh.vertices[i].z);
      bits |= static_cast<std::uint32_t>(mesh.vertices[i].z - lowest);
    }
  }
  p.z_shift = bits == 0 ? 0 : std::countr_zero(bits);
  const std::uint32_t top = static_cast<std::uint32_t>(highest - lowest) >> p.z_shift;
  p.height_bits = static_cast<int>(std::bit_width(p.holes ? top + 1 : top));
  p.z_offset = mesh.z_offset + lowest;
  return StripSource{std::move(*tree), p, lowest};
}

}  // namespace tintree::codec
