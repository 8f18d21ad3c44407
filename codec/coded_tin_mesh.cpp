#include "codec/coded_tin_mesh.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "codec/draco_mesh.h"
#include "codec/range_coder.h"
#include "codec/tin_source.h"
#include "codec/tin_walk.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

/// The form's bits: 0, the first outline is the rectangle's; 1, there are other borders; from 2 on, one more than the
/// digits of a width and height that are the same power of two, else 0 and they follow.
constexpr unsigned kRectangle = 1;
constexpr unsigned kMore = 2;
constexpr int kSizeAt = 2;

void put_frame(std::vector<std::byte>& out, const TinFrame& frame) {
  const auto width = static_cast<std::uint32_t>(frame.width);
  const bool plain = frame.width == frame.height && std::has_single_bit(width);
  const unsigned size = plain ? static_cast<unsigned>(std::bit_width(width)) << kSizeAt : 0;
  out.push_back(static_cast<std::byte>((frame.rectangle ? kRectangle : 0) | (frame.more ? kMore : 0) | size));
  if (plain) return;
  put_varint(out, width);
  put_varint(out, static_cast<std::uint32_t>(frame.height));
}

bool take_frame(std::span<const std::byte>& bytes, TinFrame& frame) {
  if (bytes.empty()) return false;
  const auto form = static_cast<unsigned>(bytes.front());
  bytes = bytes.subspan(1);
  frame.rectangle = (form & kRectangle) != 0;
  frame.more = (form & kMore) != 0;
  std::uint64_t width = std::uint64_t{1} << (form >> kSizeAt) >> 1;
  std::uint64_t height = width;
  if (width == 0 && !(take_varint(bytes, width) && take_varint(bytes, height))) return false;
  if (width < 1 || height < 1 || width > kMostTinPlace || height > kMostTinPlace) return false;
  frame.width = static_cast<std::int32_t>(width);
  frame.height = static_cast<std::int32_t>(height);
  return true;
}

TinFrame frame_of(const TinSource& source) {
  TinFrame frame{source.width(), source.height()};
  const auto sides = static_cast<std::int32_t>(source.rectangle().size());
  std::int32_t borders = 0;
  for (std::int32_t h = 0; h < source.half_edges(); ++h) borders += source.twin(h) == TinSource::kNone ? 1 : 0;
  frame.rectangle = sides > 0;
  frame.more = borders > sides;
  return frame;
}

}  // namespace

Expected<std::vector<std::byte>> CodedTinMesh::encode(const TileMesh& mesh) const {
  const auto source = TinSource::of(mesh, kMostTinPlace);
  if (!source) return DracoMesh().encode(mesh);
  const TinFrame frame = frame_of(*source);
  std::vector<std::byte> out{kTinCoded, static_cast<std::byte>(static_cast<std::int8_t>(mesh.xy_shift))};
  put_signed_varint(out, mesh.z_offset);
  put_frame(out, frame);
  RangeEncoder encoder;
  TileMesh walked;
  const auto walk = std::make_unique<TinWalk<RangeEncoder>>(encoder, frame, &*source, walked);
  if (!walk->run() || walked.triangles.size() != mesh.triangles.size()) return DracoMesh().encode(mesh);
  std::ranges::copy(encoder.finish(0), std::back_inserter(out));
  return out;
}

Expected<TileMesh> CodedTinMesh::decode(std::span<const std::byte> bytes) const {
  const auto refuse = [] { return fail(ErrorCode::kBadData, "the payload's mesh is damaged or cut short"); };
  TileMesh mesh;
  if (bytes.size() < 2) return refuse();
  if (bytes[0] != kTinCoded) return fail(ErrorCode::kBadData, "the payload has a version this program does not know");
  mesh.xy_shift = static_cast<std::int8_t>(bytes[1]);
  bytes = bytes.subspan(2);
  TinFrame frame;
  if (!take_signed_varint(bytes, mesh.z_offset) || !take_frame(bytes, frame)) return refuse();
  // A vertex takes about 12 bits or more.
  mesh.vertices.reserve(bytes.size() * 2 / 3);
  mesh.triangles.reserve(bytes.size() * 4 / 3);
  RangeDecoder decoder(bytes);
  const auto walk = std::make_unique<TinWalk<RangeDecoder>>(decoder, frame, nullptr, mesh);
  if (!walk->run() || !decoder.finished()) return refuse();
  return mesh;
}

}  // namespace tintree::codec
