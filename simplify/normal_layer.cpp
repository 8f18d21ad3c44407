#include <array>
#include <cmath>
#include <optional>

#include "codec/node_image.h"
#include "codec/normal_codec.h"
#include "simplify/picture_layer.h"

namespace tintree::simplify {
namespace {

/// How far a node without a slope of its own looks for those of others, samples.
constexpr int kFillReach = 2;

/// Normals at the DEM's samples, from central differences, or one-sided ones where a neighbour is missing. The weight
/// is always 1: a node without a slope has the mean normal of those near it, or an upright one.
class NormalLayer final : public PictureLayer {
 public:
  NormalLayer(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop)
      : layout_(&manifest.layout), view_(surface, stop) {}

  bool has_finer(const codec::TileId& id) const override { return !layout_->is_leaf_square(id.level); }

  Expected<NodeValues> make_leaf(const codec::TileId& id) override {
    const int side = layout_->tile_cells + 1;
    const std::int64_t column0 = std::int64_t{id.x} * layout_->tile_cells - kFillReach;
    const std::int64_t row0 = std::int64_t{id.y} * layout_->tile_cells - kFillReach;
    NodeValues wide(side + 2 * kFillReach, side + 2 * kFillReach);
    for (int y = 0; y < wide.height && !view_.interrupted(); ++y) {
      for (int x = 0; x < wide.width; ++x) wide.at(x, y) = normal_at(column0 + x, row0 + y);
    }
    if (view_.error()) return tl::unexpected(*view_.error());
    NodeValues out(side, side);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) out.at(x, y) = filled(wide, x + kFillReach, y + kFillReach);
    }
    return out;
  }

  const HalvingFilter& filter() const override { return kMeanHalving; }

  Expected<std::vector<std::byte>> encode(const NodeValues& values) const override {
    codec::NormalImage image(values.width);
    for (std::size_t i = 0; i < values.values.size(); ++i) {
      const auto& v = values.values[i];
      image.vectors[i] = v[3] > 0 ? std::array{v[0], v[1], v[2]} : std::array{0.0F, 0.0F, 1.0F};
    }
    return codec::encode_normals(image);
  }

  Expected<NodeValues> decode(std::span<const std::byte> payload) const override {
    const auto image = codec::decode_normals(payload, layout_->tile_cells + 1);
    if (!image) return tl::unexpected(image.error());
    NodeValues out(image->size, image->size);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
      const auto& v = image->vectors[i];
      out.values[i] = {v[0], v[1], v[2], 1};
    }
    return out;
  }

 private:
  /// Rise from one sample to the next in one direction, the mean over both sides where both are there.
  static std::optional<double> rise(double before, double here, double after) {
    if (!std::isnan(before) && !std::isnan(after)) return (after - before) / 2;
    if (!std::isnan(after)) return after - here;
    if (!std::isnan(before)) return here - before;
    return std::nullopt;
  }

  std::array<float, 4> normal_at(std::int64_t column, std::int64_t row) {
    const double here = view_.sample(column, row);
    if (std::isnan(here)) return {};
    const auto across = rise(view_.sample(column - 1, row), here, view_.sample(column + 1, row));
    const auto down = rise(view_.sample(column, row - 1), here, view_.sample(column, row + 1));
    if (!across || !down) return {};
    // The gradient (east, north) whose parts along the grid's directions are the slopes measured.
    const auto& a = layout_->axes.column;
    const auto& b = layout_->axes.row;
    const double slope_a = *across / layout_->dx_m;
    const double slope_b = *down / layout_->dy_m;
    const double det = a[0] * b[1] - a[1] * b[0];
    const double east = (slope_a * b[1] - slope_b * a[1]) / det;
    const double north = (slope_b * a[0] - slope_a * b[0]) / det;
    const double length = std::sqrt(east * east + north * north + 1);
    return {static_cast<float>(-east / length), static_cast<float>(-north / length), static_cast<float>(1 / length), 1};
  }

  static std::array<float, 4> filled(const NodeValues& wide, int x, int y) {
    if (wide.at(x, y)[3] > 0) return wide.at(x, y);
    std::array<float, 3> sum{};
    for (int dy = -kFillReach; dy <= kFillReach; ++dy) {
      for (int dx = -kFillReach; dx <= kFillReach; ++dx) {
        const auto& v = wide.at(x + dx, y + dy);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += v[k];
      }
    }
    const float length = std::hypot(sum[0], sum[1], sum[2]);
    if (length < 1e-6F) return {0, 0, 1, 1};
    return {sum[0] / length, sum[1] / length, sum[2] / length, 1};
  }

  const codec::TreeLayout* layout_;
  SurfaceView view_;
};

}  // namespace

std::unique_ptr<PictureLayer> make_normal_layer(const cache::Manifest& manifest, const ReferenceSurface& surface,
                                                const StopFlag* stop) {
  return std::make_unique<NormalLayer>(manifest, surface, stop);
}

}  // namespace tintree::simplify
