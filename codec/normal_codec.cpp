#include "codec/normal_codec.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "codec/bc4_block.h"
#include "codec/block_grid.h"

namespace tintree::codec {
namespace {

constexpr std::byte kUnit{1};         // directions only
constexpr std::byte kWithLengths{2};  // lengths follow
/// A length that rounds to 1 in the lengths' own coding.
constexpr float kUnitLength = 1 - 0.5F / 127;

float length_of(const std::array<float, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// Appends one channel's value of every texel, in blocks `stride` bytes apart that begin at `first`.
template <typename Value>
void put_channel(std::vector<std::byte>& out, std::size_t first, std::size_t stride, int size, const Value& value) {
  ValueBlock values{};
  for_each_block(
      size, [&](std::size_t, std::size_t i, int x, int y) { values[i] = value(x, y); },
      [&](std::size_t block) {
        const Bc4Block coded = encode_bc4(values);
        std::ranges::copy(coded, out.begin() + static_cast<std::ptrdiff_t>(first + block * stride));
      });
}

struct Parts {
  std::span<const std::byte> directions;
  std::span<const std::byte> lengths;
};

Expected<Parts> parts_of(std::span<const std::byte> payload, int size) {
  const std::size_t bc5 = blocks_in(size) * 2 * kBc4BlockBytes;
  const std::size_t bc4 = blocks_in(size) * kBc4BlockBytes;
  if (payload.size() == 1 + bc5 && payload[0] == kUnit) return Parts{payload.subspan(1), {}};
  if (payload.size() == 1 + bc5 + bc4 && payload[0] == kWithLengths) {
    return Parts{payload.subspan(1, bc5), payload.subspan(1 + bc5)};
  }
  return fail(ErrorCode::kBadData, "is no normal map of the tree's size");
}

/// The values of one BC4 block or two a place, -1 to 1: as many a texel.
std::vector<float> unpack_bc4(std::span<const std::byte> blocks, int size, int channels) {
  const auto step = static_cast<std::size_t>(channels);
  std::vector<float> out(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * step);
  for (std::size_t block = 0; block < blocks_in(size); ++block) {
    for (std::size_t channel = 0; channel < step; ++channel) {
      Bc4Block coded{};
      std::memcpy(coded.data(), blocks.data() + (block * step + channel) * kBc4BlockBytes, kBc4BlockBytes);
      const ValueBlock values = decode_bc4(coded);
      for_each_texel(size, block, [&](std::size_t i, int x, int y) {
        const auto texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x);
        out[texel * step + channel] = values[i];
      });
    }
  }
  return out;
}

}  // namespace

std::vector<std::byte> encode_normals(const NormalImage& image) {
  const bool unit = std::ranges::all_of(image.vectors, [](const auto& v) { return length_of(v) >= kUnitLength; });
  const std::size_t bc5 = blocks_in(image.size) * 2 * kBc4BlockBytes;
  std::vector<std::byte> out(1 + bc5 + (unit ? 0 : bc5 / 2));
  out[0] = unit ? kUnit : kWithLengths;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    put_channel(out, 1 + axis * kBc4BlockBytes, 2 * kBc4BlockBytes, image.size, [&](int x, int y) {
      const auto& v = image.at(x, y);
      const float length = length_of(v);
      return length > 0 ? v[axis] / length : 0;
    });
  }
  if (!unit)
    put_channel(out, 1 + bc5, kBc4BlockBytes, image.size, [&](int x, int y) { return length_of(image.at(x, y)); });
  return out;
}

Expected<NormalImage> decode_normals(std::span<const std::byte> payload, int size) {
  const auto parts = parts_of(payload, size);
  if (!parts) return tl::unexpected(parts.error());
  const std::vector<float> directions = unpack_bc4(parts->directions, size, 2);
  const std::vector<float> lengths =
      parts->lengths.empty() ? std::vector<float>() : unpack_bc4(parts->lengths, size, 1);
  NormalImage image(size);
  for (std::size_t i = 0; i < image.vectors.size(); ++i) {
    const float east = directions[2 * i];
    const float north = directions[2 * i + 1];
    const float up = std::sqrt(std::max(0.0F, 1 - east * east - north * north));
    // Two coded parts may be a little longer than 1 together.
    const float length = (lengths.empty() ? 1 : std::max(lengths[i], 0.0F)) / std::max(1.0F, std::hypot(east, north));
    image.vectors[i] = {length * east, length * north, length * up};
  }
  return image;
}

Expected<NormalPixels> normal_pixels(std::span<const std::byte> payload, int size) {
  const auto parts = parts_of(payload, size);
  if (!parts) return tl::unexpected(parts.error());
  NormalPixels out;
  out.directions = {PixelFormat::kBc5Snorm, size, {parts->directions.begin(), parts->directions.end()}};
  if (!parts->lengths.empty()) {
    out.lengths = {PixelFormat::kBc4Snorm, size, {parts->lengths.begin(), parts->lengths.end()}};
  }
  return out;
}

}  // namespace tintree::codec
