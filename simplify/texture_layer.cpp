#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/node_image.h"
#include "codec/texture_codec.h"
#include "simplify/picture_layer.h"
#include "simplify/srgb.h"

namespace tintree::simplify {
namespace {

/// The finest textures are read at this many times their resolution at most, and with no more nodes a side.
constexpr int kMostHalvings = 3;
constexpr int kMostNodes = 2048;
/// A node whose covered share is less is not covered.
constexpr float kCovered = 0.5F;

/// Colours in linear light; the weight says what a photo covers.
class TextureLayer final : public PictureLayer {
 public:
  TextureLayer(const cache::Manifest& manifest, const cache::OrthoSource& photos)
      : manifest_(&manifest),
        squares_(manifest.picture_layout(cache::PictureKind::kTexture)),
        photos_(&photos),
        codec_(codec::find_texture_codec(manifest.texture_codec)) {
    // Photos finer than the finest textures are read as they are and halved in linear light; what GDAL filters, it
    // filters as bytes.
    const double finest = step(squares_.leaf_level);
    while (halvings_ < kMostHalvings && is_finer(photos.pixel_samples(), std::ldexp(finest, -halvings_)) &&
           (manifest.texture_size << (halvings_ + 1)) <= kMostNodes) {
      ++halvings_;
    }
  }

  bool has_finer(const codec::TileId& id) const override {
    if (squares_.halvings(id.level) < squares_.halvings(manifest_->layout.leaf_level)) return true;
    return !squares_.is_leaf_square(id.level) &&
           is_finer(photos_->pixel_samples_in(squares_.cells(id)), step(id.level));
  }

  Expected<NodeValues> make_leaf(const codec::TileId& id) override {
    // On coarser squares there are no finer photos.
    const int halvings = squares_.is_leaf_square(id.level) ? halvings_ : 0;
    int margin = 0;
    for (int i = 0; i < halvings; ++i) margin = 2 * margin + filter().reach;
    const std::int64_t across = std::int64_t{manifest_->texture_size} << halvings;
    const int side = static_cast<int>(across) + 1 + 2 * margin;
    const auto window = photos_->read(std::ldexp(step(id.level), -halvings), id.x * across - margin,
                                      id.y * across - margin, side, side);
    if (!window) return tl::unexpected(window.error());
    NodeValues values = from_bytes(window->rgba, side);
    for (int i = 0; i < halvings; ++i) {
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

  /// Samples between the nodes of a picture of `level`.
  double step(int level) const { return static_cast<double>(squares_.cells_across(level)) / manifest_->texture_size; }

  const cache::Manifest* manifest_;
  const codec::TreeLayout squares_;
  const cache::OrthoSource* photos_;
  const codec::TextureCodec* codec_;
  int halvings_ = 0;  ///< Of what the finest textures are read at.
};

}  // namespace

std::unique_ptr<PictureLayer> make_texture_layer(const cache::Manifest& manifest, const cache::OrthoSource& photos) {
  return std::make_unique<TextureLayer>(manifest, photos);
}

}  // namespace tintree::simplify
