#include "codec/jpeg_texture.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include <turbojpeg.h>

namespace tintree::codec {
namespace {

constexpr std::byte kWhole{1};     // all texels are covered
constexpr std::byte kWithMask{2};  // a bit a texel says which are
constexpr int kQuality = 85;
constexpr std::uint8_t kCovered = 128;

struct HandleCloser {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, HandleCloser>;

struct BufferFreer {
  void operator()(unsigned char* buffer) const { tjFree(buffer); }
};

std::size_t texels_in(int size) { return static_cast<std::size_t>(size) * static_cast<std::size_t>(size); }
std::size_t mask_bytes(int size) { return (texels_in(size) + 7) / 8; }

bool is_whole(const ColorImage& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] < kCovered) return false;
  }
  return true;
}

/// The picture with the mean colour where it is not covered, which costs few bytes and keeps ringing off the rest.
std::vector<std::uint8_t> filled(const ColorImage& image) {
  std::array<std::uint64_t, 4> sum{};
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] < kCovered) continue;
    for (std::size_t k = 0; k < 3; ++k) sum[k] += image.rgba[i + k];
    ++sum[3];
  }
  std::vector<std::uint8_t> out = image.rgba;
  for (std::size_t i = 0; i < out.size() && sum[3] > 0; i += 4) {
    if (out[i + 3] >= kCovered) continue;
    for (std::size_t k = 0; k < 3; ++k) out[i + k] = static_cast<std::uint8_t>(sum[k] / sum[3]);
  }
  return out;
}

tl::unexpected<Error> damaged() { return fail(ErrorCode::kBadData, "is no jpeg picture of the tree's size"); }

}  // namespace

Expected<std::vector<std::byte>> JpegTexture::encode(const ColorImage& image) const {
  const bool whole = is_whole(image);
  const std::vector<std::uint8_t> rgba = whole ? image.rgba : filled(image);
  const Handle encoder(tjInitCompress());
  unsigned char* buffer = nullptr;
  unsigned long length = 0;
  const bool done = encoder != nullptr && tjCompress2(encoder.get(), rgba.data(), image.size, 0, image.size, TJPF_RGBX,
                                                      &buffer, &length, TJSAMP_420, kQuality, TJFLAG_ACCURATEDCT) == 0;
  const std::unique_ptr<unsigned char, BufferFreer> owner(buffer);
  if (!done)
    return fail(ErrorCode::kIo, std::string("a texture cannot be coded as JPEG: ") + tjGetErrorStr2(encoder.get()));
  std::vector<std::byte> out{whole ? kWhole : kWithMask};
  if (!whole) {
    out.resize(1 + mask_bytes(image.size));
    for (std::size_t i = 0; i < texels_in(image.size); ++i) {
      if (image.rgba[4 * i + 3] >= kCovered) out[1 + i / 8] |= std::byte{1} << (i % 8);
    }
  }
  const auto stream = std::as_bytes(std::span(buffer, length));
  out.insert(out.end(), stream.begin(), stream.end());
  return out;
}

Expected<ColorImage> JpegTexture::decode(std::span<const std::byte> payload, int size) const {
  if (payload.empty() || (payload[0] != kWhole && payload[0] != kWithMask)) return damaged();
  const bool whole = payload[0] == kWhole;
  const std::size_t head = whole ? 1 : 1 + mask_bytes(size);
  if (payload.size() <= head) return damaged();
  const auto* stream = reinterpret_cast<const unsigned char*>(payload.data() + head);
  const auto length = static_cast<unsigned long>(payload.size() - head);
  const Handle decoder(tjInitDecompress());
  int width = 0;
  int height = 0;
  int sampling = 0;
  int space = 0;
  if (decoder == nullptr ||
      tjDecompressHeader3(decoder.get(), stream, length, &width, &height, &sampling, &space) != 0 || width != size ||
      height != size) {
    return damaged();
  }
  ColorImage image(size);
  if (tjDecompress2(decoder.get(), stream, length, image.rgba.data(), size, 0, size, TJPF_RGBA, TJFLAG_ACCURATEDCT) !=
      0) {
    return damaged();
  }
  for (std::size_t i = 0; i < texels_in(size) && !whole; ++i) {
    if ((payload[1 + i / 8] & (std::byte{1} << (i % 8))) == std::byte{0})
      std::fill_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, std::uint8_t{0});
  }
  return image;
}

Expected<PixelArray> JpegTexture::pixels(std::span<const std::byte> payload, int size) const {
  const auto image = decode(payload, size);
  if (!image) return tl::unexpected(image.error());
  return as_pixels(*image);
}

}  // namespace tintree::codec
