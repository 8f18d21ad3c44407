#include "codec/strip_payload.h"

#include "codec/tile_mesh.h"
#include "codec/varint.h"

namespace tintree::codec {

std::uint64_t StripHeaderLayout::pack(const StripHeader& h) const {
  std::uint64_t bits = 0;
  int at = 0;
  const auto put = [&](std::uint64_t value, int width) {
    bits |= value << at;
    at += width;
  };
  put(static_cast<std::uint64_t>(h.x), xy_bits);
  put(static_cast<std::uint64_t>(h.y), xy_bits);
  put(static_cast<std::uint64_t>(h.edge.direction), 3);
  put(static_cast<std::uint64_t>(h.edge.size), size_bits);
  put(h.back - 2, 3);
  put(h.back_is_v1 ? 1 : 0, 1);
  put(h.left ? 1 : 0, 1);
  return bits;
}

StripHeader StripHeaderLayout::unpack(std::uint64_t bits) const {
  const auto take = [&](int width) {
    const auto value = static_cast<std::uint32_t>(bits & ((std::uint64_t{1} << width) - 1));
    bits >>= width;
    return value;
  };
  StripHeader h;
  h.x = static_cast<std::int32_t>(take(xy_bits));
  h.y = static_cast<std::int32_t>(take(xy_bits));
  h.edge.direction = static_cast<int>(take(3));
  h.edge.size = static_cast<int>(take(size_bits));
  h.back = take(3) + 2;
  h.back_is_v1 = take(1) != 0;
  h.left = take(1) != 0;
  return h;
}

void put_strip_head(std::vector<std::byte>& out, std::byte version, const StripHead& head) {
  out.insert(out.end(), {version, static_cast<std::byte>(static_cast<std::int8_t>(head.xy_shift)),
                         static_cast<std::byte>(head.levels), static_cast<std::byte>(head.height_bits),
                         static_cast<std::byte>(head.z_shift | head.fine << 5 | (head.holes ? 64 : 0))});
  put_signed_varint(out, head.z_offset);
  put_varint(out, head.triangles);
}

Expected<StripHead> take_strip_head(std::span<const std::byte>& bytes, std::byte version) {
  const auto refuse = [](const char* why) { return fail(ErrorCode::kBadData, why); };
  StripHead p;
  if (bytes.size() < 6) return refuse("the payload is cut short");
  if (bytes[0] != version) return refuse("the payload has a version this program does not know");
  p.xy_shift = static_cast<std::int8_t>(bytes[1]);
  p.levels = static_cast<int>(bytes[2]);
  p.height_bits = static_cast<int>(bytes[3]);
  const auto form = static_cast<unsigned>(bytes[4]);
  p.z_shift = static_cast<int>(form & 31);
  p.fine = static_cast<int>(form >> 5 & 1);
  p.holes = (form >> 6 & 1) != 0;
  bytes = bytes.subspan(5);
  std::uint64_t triangles = 0;
  if (!take_signed_varint(bytes, p.z_offset) || !take_varint(bytes, triangles))
    return refuse("the payload is cut short");
  if (p.levels < 1 || p.levels > kMaxStripLevels || p.height_bits > kMaxStripHeightBits ||
      p.z_shift + p.height_bits > kMaxStripHeightBits || form > 127 || triangles < 4 || triangles > kMaxTileTriangles) {
    return refuse("the payload's head is out of range");
  }
  p.triangles = static_cast<std::uint32_t>(triangles);
  return p;
}

Expected<StripHead> read_strip_head(std::span<const std::byte> bytes) {
  const bool coded = !bytes.empty() && bytes.front() == kStripCoded;
  return take_strip_head(bytes, coded ? kStripCoded : kStripPacked);
}

Expected<StripPayload> open_strip(std::span<const std::byte> bytes) {
  const auto head = take_strip_head(bytes, kStripPacked);
  if (!head) return tl::unexpected(head.error());
  StripPayload p;
  static_cast<StripHead&>(p) = *head;
  const std::size_t front = p.sub_strips() * StripHeaderLayout::of(p.levels).bytes;
  const std::size_t body = ((p.triangles + std::size_t{2}) * static_cast<std::size_t>(p.height_bits + 2) + 7) / 8;
  if (bytes.size() != front + body) return fail(ErrorCode::kBadData, "the payload is cut short or too long");
  p.headers = bytes.first(front);
  p.entries = bytes.subspan(front);
  return p;
}

}  // namespace tintree::codec
