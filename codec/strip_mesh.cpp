#include "codec/strip_mesh.h"

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/coded_strip_mesh.h"
#include "codec/strip_follower.h"
#include "codec/strip_packer.h"
#include "codec/strip_source.h"

namespace tintree::codec {
namespace {

/// Which entries hold the heights of the entering edge's vertices.
struct HeightEntries {
  std::uint32_t v1 = 0;
  std::uint32_t v2 = 1;

  void fill(StripHeader& header, std::uint32_t triangle) const {
    const std::uint32_t entry = triangle + 2;
    header.back_is_v1 = entry - v1 != 1;
    header.back = entry - (header.back_is_v1 ? v1 : v2);
  }
  void step(bool left, std::uint32_t triangle) { (left ? v2 : v1) = triangle + 2; }
};

}  // namespace

Expected<std::vector<std::byte>> StripMesh::encode(const TileMesh& mesh) const {
  const auto source = find_strip(mesh);
  if (!source) return tl::unexpected(source.error());
  std::optional<StripPacker> packer;
  HeightEntries heights;
  std::uint32_t i = 0;
  source->walk([&](const StripStep& s) {
    if (i == 0) packer.emplace(source->head, source->code(s.v1), source->code(s.v2));
    if (i % kSubStrip == 0) {
      StripHeader header;
      header.x = static_cast<std::int32_t>(s.v1.x);
      header.y = static_cast<std::int32_t>(s.v1.y);
      header.edge = edge_between(s.v1, s.v2);
      header.left = s.left;
      heights.fill(header, i);
      packer->header(header);
    }
    packer->entry(s.type, source->code(s.v3));
    heights.step(s.left, i++);
  });
  return packer->finish();
}

Expected<TileMesh> StripMesh::decode(std::span<const std::byte> bytes) const {
  if (!bytes.empty() && bytes.front() == kStripCoded) return CodedStripMesh().decode(bytes);
  const auto refuse = [] { return fail(ErrorCode::kBadData, "the payload's strip is damaged"); };
  const auto p = open_strip(bytes);
  if (!p) return tl::unexpected(p.error());
  StripFollower path(*p, p->header(0));
  StripWinding winding;
  std::vector<std::uint32_t> heights{p->entry(0) >> 2, p->entry(1) >> 2};
  heights.reserve(p->triangles + std::size_t{2});
  for (std::uint32_t i = 0; i < p->triangles; ++i) {
    const std::uint32_t entry = p->entry(i + std::size_t{2});
    if ((entry & 3) == 3) return refuse();
    const auto type = static_cast<StripType>(entry & 3);
    const bool left = winding.next(type);
    if (i % kSubStrip == 0 && !(p->header(i / kSubStrip) == path.header(left))) return refuse();
    if (!path.step(type, left)) return refuse();
    heights.push_back(entry >> 2);
  }
  return path.mesh(heights);
}

}  // namespace tintree::codec
