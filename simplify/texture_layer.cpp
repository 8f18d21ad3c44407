#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/node_image.h"
#include "codec/texture_codec.h"
#include "simplify/picture_layer.h"
#include "simplify/srgb.h"

namespace tintree::simplify {
namespace {

/// A leaf is read at this many times its resolution at most, and with no more nodes a side.
constexpr int kMostHalvings = 3;
constexpr int kMostNodes = 2048;
/// A node whose covered share is less is not covered.
constexpr float kCovered = 0.5F;

/// Colours in linear light; the weight says what a photo covers.
class TextureLayer final : public PictureLayer {
 public:
  TextureLayer(const cache::Manifest& manifest, const cache::OrthoSource& photos)
      : manifest_(&manifest), photos_(&photos), codec_(codec::find_texture_codec(manifest.texture_codec)) {
    // Photos finer than the leaves are read as they are and halved in linear light; what GDAL filters, it filters as
    // bytes.
    step_ = static_cast<double>(manifest.layout.tile_cells) / manifest.texture_size;
    const double finer = std::log2(step_ / photos.pixel_samples());
    while (halvings_ < kMostHalvings && halvings_ + 0.25 < finer &&
           (manifest.texture_size << (halvings_ + 1)) <= kMostNodes) {
      ++halvings_;
    }
  }

  Expected<NodeValues> make_leaf(const codec::TileId& id) override {
    int margin = 0;
    for (int i = 0; i < halvings_; ++i) margin = 2 * margin + filter().reach;
    const std::int64_t across = std::int64_t{manifest_->texture_size} << halvings_;
    const int side = static_cast<int>(across) + 1 + 2 * margin;
    const auto window =
        photos_->read(std::ldexp(step_, -halvings_), id.x * across - margin, id.y * across - margin, side, side);
    if (!window) return tl::unexpected(window.error());
    NodeValues values = from_bytes(window->rgba, side);
    for (int i = 0; i < halvings_; ++i) {
      values = halve(values, filter());
      settle_coverage(values);
    }
    return values;
  }

  const HalvingFilter& filter() const override { return kSharpHalving; }

  Expected<std::vector<std::byte>> encode(const NodeValues& values) const override {
    codec::ColorImage image(values.width);
    bool covered = false;
    for (std::size_t i = 0; i < values.values.size(); ++i) {
      const auto& v = values.values[i];
      if (v[3] < kCovered) continue;
      covered = true;
      for (std::size_t k = 0; k < 3; ++k) image.rgba[4 * i + k] = srgb_of(v[k]);
      image.rgba[4 * i + 3] = 255;
    }
    if (!covered) return std::vector<std::byte>();
    return codec_->encode(image);
  }

  Expected<NodeValues> decode(std::span<const std::byte> payload) const override {
    const auto image = codec_->decode(payload, manifest_->texture_size + 1);
    if (!image) return tl::unexpected(image.error());
    return from_bytes(image->rgba, image->size);
  }

 private:
  static NodeValues from_bytes(const std::vector<std::uint8_t>& rgba, int side) {
    NodeValues out(side, side);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
      if (rgba[4 * i + 3] < 128) continue;
      out.values[i] = {linear_of(rgba[4 * i]), linear_of(rgba[4 * i + 1]), linear_of(rgba[4 * i + 2]), 1};
    }
    return out;
  }

  static void settle_coverage(NodeValues& values) {
    for (auto& v : values.values) v[3] = v[3] < kCovered ? 0.0F : 1.0F;
  }

  const cache::Manifest* manifest_;
  const cache::OrthoSource* photos_;
  const codec::TextureCodec* codec_;
  double step_ = 1;  ///< Samples between the nodes of a leaf.
  int halvings_ = 0;
};

}  // namespace

std::unique_ptr<PictureLayer> make_texture_layer(const cache::Manifest& manifest, const cache::OrthoSource& photos) {
  return std::make_unique<TextureLayer>(manifest, photos);
}

}  // namespace tintree::simplify
