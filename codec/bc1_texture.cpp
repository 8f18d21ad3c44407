#include "codec/bc1_texture.h"

#include <algorithm>
#include <cstring>

#include "codec/bc1_block.h"
#include "codec/block_grid.h"

namespace tintree::codec {
namespace {

constexpr std::byte kVersion{1};

/// The blocks of a payload whose length is right.
Expected<std::span<const std::byte>> blocks_of(std::span<const std::byte> payload, int size) {
  if (payload.size() != 1 + blocks_in(size) * kBc1BlockBytes || payload[0] != kVersion) {
    return fail(ErrorCode::kBadData, "is no bc1 picture of the tree's size");
  }
  return payload.subspan(1);
}

/// The texels of `size` x `size` in blocks, as many as blocks_in(size).
ColorImage unpack_bc1(std::span<const std::byte> blocks, int size) {
  ColorImage image(size);
  for (std::size_t block = 0; block < blocks_in(size); ++block) {
    Bc1Block coded{};
    std::memcpy(coded.data(), blocks.data() + block * kBc1BlockBytes, kBc1BlockBytes);
    const ColorBlock texels = decode_bc1(coded);
    for_each_texel(size, block, [&](std::size_t i, int x, int y) { std::ranges::copy(texels[i], image.at(x, y)); });
  }
  return image;
}

}  // namespace

Expected<std::vector<std::byte>> Bc1Texture::encode(const ColorImage& image) const {
  std::vector<std::byte> out(1 + blocks_in(image.size) * kBc1BlockBytes);
  out[0] = kVersion;
  ColorBlock texels{};
  for_each_block(
      image.size, [&](std::size_t, std::size_t i, int x, int y) { std::copy_n(image.at(x, y), 4, texels[i].begin()); },
      [&](std::size_t block) {
        const Bc1Block coded = encode_bc1(texels);
        std::ranges::copy(coded, out.begin() + 1 + static_cast<std::ptrdiff_t>(block * kBc1BlockBytes));
      });
  return out;
}

PixelArray unpacked(const PixelArray& blocks) { return as_pixels(unpack_bc1(blocks.bytes, blocks.size)); }

Expected<ColorImage> Bc1Texture::decode(std::span<const std::byte> payload, int size) const {
  const auto blocks = blocks_of(payload, size);
  if (!blocks) return tl::unexpected(blocks.error());
  return unpack_bc1(*blocks, size);
}

Expected<PixelArray> Bc1Texture::pixels(std::span<const std::byte> payload, int size) const {
  const auto blocks = blocks_of(payload, size);
  if (!blocks) return tl::unexpected(blocks.error());
  return PixelArray{PixelFormat::kBc1, size, {blocks->begin(), blocks->end()}};
}

}  // namespace tintree::codec
