#include "codec/strip_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "codec/split_fans.h"
#include "codec/split_flags.h"
#include "codec/strip_payload.h"
#include "codec/strip_tree.h"
#include "codec/varint.h"

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

/// Numbers of a few bits each, densely packed, the first in the lowest bits.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::byte>& out) : out_(&out) {}
  void put(std::uint32_t value, int bits) {
    word_ |= std::uint64_t{value} << filled_;
    for (filled_ += bits; filled_ >= 8; filled_ -= 8, word_ >>= 8) out_->push_back(static_cast<std::byte>(word_));
  }
  void finish() {
    if (filled_ > 0) out_->push_back(static_cast<std::byte>(word_));
  }

 private:
  std::vector<std::byte>* out_;
  std::uint64_t word_ = 0;
  int filled_ = 0;
};

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

/// A vertex of the strip, its height as it is coded.
struct Vertex {
  std::int32_t x, y;
  std::uint32_t code;
};

/// The vertex at an edge's other end.
Vertex towards(const Vertex& from, const StripEdge& edge, int sign, std::uint32_t code) {
  const auto d = static_cast<std::size_t>(edge.direction);
  const std::int32_t length = sign * (1 << edge.size);
  return {from.x + kStripX[d] * length, from.y + kStripY[d] * length, code};
}

}  // namespace

Expected<std::vector<std::byte>> StripMesh::encode(const TileMesh& mesh) const {
  if (mesh.triangles.empty() || mesh.triangles.size() > kMaxTileTriangles / 2)
    return fail(ErrorCode::kBadData, "the tile has no triangles, or more than the format allows");
  const auto tree = find_tree(mesh);
  if (!tree) return fail(ErrorCode::kBadData, "the mesh is no restricted quadtree mesh, or one too fine for a strip");
  std::int32_t lowest = kMaxHeightAddress;
  std::int32_t highest = 0;
  std::uint32_t bits = 0;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) lowest = std::min(lowest, mesh.vertices[i].z);
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      highest = std::max(highest, mesh.vertices[i].z);
      bits |= static_cast<std::uint32_t>(mesh.vertices[i].z - lowest);
    }
  }
  StripPayload p;
  p.z_shift = bits == 0 ? 0 : std::countr_zero(bits);
  const std::uint32_t top = static_cast<std::uint32_t>(highest - lowest) >> p.z_shift;
  p.holes = tree->holes();
  p.height_bits = std::bit_width(p.holes ? top + 1 : top);
  p.levels = tree->levels();

  std::vector<std::byte> out{std::byte{1}, static_cast<std::byte>(static_cast<std::int8_t>(mesh.xy_shift)),
                             static_cast<std::byte>(p.levels), static_cast<std::byte>(p.height_bits),
                             static_cast<std::byte>(p.z_shift | tree->fine() << 5 | (p.holes ? 64 : 0))};
  put_signed_varint(out, mesh.z_offset + lowest);
  put_varint(out, tree->triangles());
  const StripHeaderLayout layout = StripHeaderLayout::of(p.levels);
  std::size_t header_at = out.size();
  out.resize(out.size() + (tree->triangles() + kSubStrip - 1) / kSubStrip * layout.bytes);
  BitWriter entries(out);
  const auto put_entry = [&](StripType type, const SplitPoint& v) {
    const std::int32_t z = tree->z(v);
    const std::uint32_t code = z < 0 ? p.missing() : static_cast<std::uint32_t>(z - lowest) >> p.z_shift;
    entries.put(code << 2 | static_cast<std::uint32_t>(type), p.height_bits + 2);
  };
  HeightEntries heights;
  std::uint32_t i = 0;
  walk_strip(
      std::int64_t{1} << p.levels, [&](const SplitPoint& at) { return tree->is_split(at); },
      [&](const StripStep& s) {
        if (i == 0) {
          put_entry(StripType::kA, s.v1);
          put_entry(StripType::kA, s.v2);
        }
        if (i % kSubStrip == 0) {
          StripHeader header;
          header.x = static_cast<std::int32_t>(s.v1.x);
          header.y = static_cast<std::int32_t>(s.v1.y);
          header.edge = edge_between(s.v1, s.v2);
          header.left = s.left;
          heights.fill(header, i);
          const std::uint64_t packed = layout.pack(header);
          std::memcpy(out.data() + header_at, &packed, layout.bytes);
          header_at += layout.bytes;
        }
        put_entry(s.type, s.v3);
        heights.step(s.left, i++);
      });
  entries.finish();
  return out;
}

Expected<TileMesh> StripMesh::decode(std::span<const std::byte> bytes) const {
  const auto refuse = [] { return fail(ErrorCode::kBadData, "the payload's strip is damaged"); };
  auto opened = open_strip(bytes);
  if (!opened) return tl::unexpected(opened.error());
  const StripPayload& p = *opened;
  const std::int32_t span = 1 << p.levels;

  const auto inside = [span](const Vertex& v) { return v.x >= 0 && v.y >= 0 && v.x <= span && v.y <= span; };
  std::vector<std::array<Vertex, 3>> strip;
  strip.reserve(p.triangles);
  SplitFlags points(span);
  HeightEntries heights;
  StripWinding winding;
  const StripHeader first = p.header(0);
  StripEdge edge = first.edge;
  if (edge.size > p.levels) return refuse();
  Vertex v1{first.x, first.y, p.entry(0) >> 2};
  Vertex v2 = towards(v1, edge, 1, p.entry(1) >> 2);
  if (!inside(v1) || !inside(v2)) return refuse();
  points.set(v1.x, v1.y);
  points.set(v2.x, v2.y);
  for (std::uint32_t i = 0; i < p.triangles; ++i) {
    const std::uint32_t entry = p.entry(i + std::size_t{2});
    if ((entry & 3) == 3) return refuse();
    const auto type = static_cast<StripType>(entry & 3);
    const bool left = winding.next(type);
    if (i % kSubStrip == 0) {
      StripHeader header{v1.x, v1.y, edge, 2, true, left};
      heights.fill(header, i);
      if (!(p.header(i / kSubStrip) == header)) return refuse();
    }
    edge = edge.next(type, left);
    if (edge.size < 0 || edge.size > p.levels) return refuse();
    const Vertex v3 = left ? towards(v1, edge, 1, entry >> 2) : towards(v2, edge, -1, entry >> 2);
    if (!inside(v3)) return refuse();
    points.set(v3.x, v3.y);
    strip.push_back({v1, v2, v3});
    (left ? v2 : v1) = v3;
    heights.step(left, i);
  }

  constexpr std::uint32_t kNew = UINT32_MAX;
  TileMesh mesh;
  mesh.xy_shift = p.xy_shift;
  mesh.z_offset = p.z_offset;
  mesh.triangles.reserve(p.triangles);
  std::vector<std::uint32_t> index(static_cast<std::size_t>(points.number()), kNew);
  mesh.vertices.reserve(index.size());
  const std::uint32_t odd = p.fine != 0 ? 1 : 0;
  for (const auto& corners : strip) {
    if (std::ranges::any_of(corners, [&](const Vertex& v) { return v.code == p.missing(); })) continue;
    Triangle& t = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vertex& v = corners[k];
      if ((static_cast<std::uint32_t>(v.x | v.y) & odd) != 0) return refuse();
      const GridVertex at{v.x >> p.fine, v.y >> p.fine, static_cast<std::int32_t>(v.code << p.z_shift)};
      std::uint32_t& i = index[static_cast<std::size_t>(points.rank(v.x, v.y))];
      if (i == kNew) {
        i = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(at);
      } else if (mesh.vertices[i].z != at.z) {
        return refuse();
      }
      t[k] = i;
    }
  }
  if (p.holes) split_fans(mesh);
  return mesh;
}

}  // namespace tintree::codec
