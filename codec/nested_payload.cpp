#include "codec/nested_payload.h"

#include <memory>

#include "codec/nested_tile.h"
#include "codec/point_coder.h"
#include "codec/tile_mesh.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

constexpr auto kPayloadVersion = std::byte{2};
/// The most points that a block of so many bytes can add; some 300 are possible.
std::size_t most_points(std::size_t bytes) { return 4096 * (bytes + 16); }

tl::unexpected<Error> damaged() { return fail(ErrorCode::kBadData, "the payload is damaged or cut short"); }

}  // namespace

Expected<NestedPayload> parse_nested(std::span<const std::byte> bytes, int levels) {
  NestedPayload out;
  const std::size_t all = bytes.size();
  if (bytes.size() < 4) return damaged();
  if (bytes[0] != kPayloadVersion)
    return fail(ErrorCode::kBadData, "the payload has a version this program does not know");
  out.xy_shift = static_cast<std::int8_t>(bytes[1]);
  out.side_bits = static_cast<int>(bytes[2]);
  const int count = static_cast<int>(bytes[3]);
  if (out.side_bits < 1 || out.side_bits > NestedPoints::kMostSideBits || count < 1 ||
      count > NestedTile::kMostLevels) {
    return damaged();
  }
  bytes = bytes.subspan(4);
  if (!take_signed_varint(bytes, out.z_offset)) return damaged();
  std::size_t points = 0;
  for (int i = 0; i < count; ++i) {
    std::uint64_t added = 0;
    std::uint64_t length = 0;
    if (!take_varint(bytes, added) || !take_varint(bytes, length)) return damaged();
    if (length > (std::uint64_t{1} << 40) || added > most_points(length) || points + added > kMaxTileVertices)
      return damaged();
    points += added;
    out.blocks.push_back({added, {}});
    out.block_bytes.push_back(length);
  }
  out.header_bytes = all - bytes.size();
  for (int i = 0; i < std::min(count, levels); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (out.block_bytes[k] > bytes.size()) return damaged();
    out.blocks[k].bytes = bytes.first(out.block_bytes[k]);
    bytes = bytes.subspan(out.block_bytes[k]);
  }
  if (levels >= count && !bytes.empty()) return damaged();
  return out;
}

Expected<NestedPoints> read_points(const NestedPayload& payload, int levels) {
  NestedPoints points(payload.side_bits);
  const auto coder = std::make_unique<PointCoder<RangeDecoder>>(points, nullptr);
  std::size_t count = 0;
  for (std::size_t i = 0; i < payload.blocks.size() && static_cast<int>(i) < levels; ++i) {
    RangeDecoder decoder(payload.blocks[i].bytes);
    count += payload.blocks[i].points;
    if (!coder->code(decoder, count) || points.points().size() != count) return damaged();
  }
  return points;
}

Expected<std::vector<std::byte>> write_nested(int xy_shift, std::int64_t z_offset, int side_bits, int levels,
                                              const NestedPoints& points, NestedPoints& written) {
  const auto coder = std::make_unique<PointCoder<RangeEncoder>>(written, &points);
  std::vector<std::byte> out{kPayloadVersion, static_cast<std::byte>(static_cast<std::int8_t>(xy_shift)),
                             static_cast<std::byte>(side_bits), static_cast<std::byte>(levels)};
  put_signed_varint(out, z_offset);
  std::vector<std::byte> blocks;
  for (int level = 0; level < levels; ++level) {
    const std::size_t before = written.points().size();
    RangeEncoder encoder;
    if (!coder->code(encoder, kMaxTileVertices)) {
      return fail(ErrorCode::kBadData,
                  "the tile has more vertices than the format allows; choose a larger --error or a smaller --tile");
    }
    const std::vector<std::byte> block = encoder.finish();
    put_varint(out, written.points().size() - before);
    put_varint(out, block.size());
    blocks.insert(blocks.end(), block.begin(), block.end());
  }
  if (written.points().size() != points.points().size())
    return fail(ErrorCode::kBadData, "the mesh is not one of nested right triangles");
  out.insert(out.end(), blocks.begin(), blocks.end());
  return out;
}

}  // namespace tintree::codec
