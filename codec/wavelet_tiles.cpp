#include "codec/wavelet_tiles.h"

#include <algorithm>
#include <utility>

#include "codec/right_triangle_code.h"

namespace tintree::codec {
namespace {

constexpr int kFractionBits = 10;

int patch_side(const TreeLayout& layout) { return layout.tile_cells + 2 * kPatchMargin; }

/// The patch's height at a sample of the DEM, between the four of its own around it.
class PatchGuess {
 public:
  PatchGuess(const TreeLayout& layout, const TileId& id, const Patch& patch)
      : patch_(&patch), shift_(layout.leaf_level - id.level) {}

  std::int64_t operator()(std::int64_t x, std::int64_t y) const {
    // In half samples of the DEM from the middle of the patch's first one.
    const std::int64_t spacing = std::int64_t{2} << shift_;
    const std::int64_t first = (std::int64_t{1} << shift_) - 1 - spacing * kPatchMargin;
    const std::int64_t across = 2 * x - first;
    const std::int64_t down = 2 * y - first;
    const auto i = static_cast<int>(across / spacing);
    const auto j = static_cast<int>(down / spacing);
    // Places between samples count in 1024ths at most, so that no product is too large.
    const int spare = std::max(0, shift_ - kFractionBits + 1);
    const std::int64_t whole = spacing >> spare;
    const std::int64_t u = across % spacing >> spare;
    const std::int64_t v = down % spacing >> spare;
    const auto between = [whole](std::int64_t a, std::int64_t b, std::int64_t f) { return a + (b - a) * f / whole; };
    const auto row = [&](int k) {
      return between(patch_->at(i, k), u == 0 ? patch_->at(i, k) : patch_->at(i + 1, k), u);
    };
    return between(row(j), v == 0 ? row(j) : row(j + 1), v);
  }

 private:
  const Patch* patch_;
  int shift_;
};

}  // namespace

Patch wavelet_prediction(const TreeLayout& layout, const TileId& id, const Patch* parent) {
  if (parent == nullptr) return {patch_side(layout), 0};
  return predict_patch(*parent, static_cast<int>((id.x & 1) | (id.y & 1) << 1), 2);
}

Expected<std::vector<std::byte>> encode_wavelet_tile(const TreeLayout& layout, const TileId& id, const TileMesh& mesh,
                                                     const EncodedPatch& patch) {
  auto triangles =
      encode_right_triangles(mesh, layout.cells_across(id.level), PatchGuess(layout, id, patch.reconstruction));
  if (!triangles) return triangles;
  std::vector<std::byte> out = patch.bytes;
  out.insert(out.end(), triangles->begin(), triangles->end());
  return out;
}

Expected<Patch> WaveletDecoder::prediction(const TileId& id) {
  if (id.level == 0) return wavelet_prediction(layout_, id, nullptr);
  const auto above = patch(layout_.parent(id));
  if (!above) return tl::unexpected(above.error());
  return wavelet_prediction(layout_, id, above->get());
}

Expected<std::shared_ptr<const Patch>> WaveletDecoder::take_patch(const TileId& id, std::span<const std::byte>& bytes) {
  const auto predicted = prediction(id);
  if (!predicted) return tl::unexpected(predicted.error());
  auto made = decode_patch(bytes, *predicted);
  if (!made) return tl::unexpected(made.error());
  auto out = std::make_shared<const Patch>(std::move(*made));
  const std::scoped_lock lock(turn_);
  patches_.keep(id, out);
  return out;
}

Expected<std::shared_ptr<const Patch>> WaveletDecoder::patch(const TileId& id) {
  {
    const std::scoped_lock lock(turn_);
    if (auto known = patches_.find(id)) return known;
  }
  auto bytes = read_(id);
  if (!bytes) return tl::unexpected(bytes.error());
  std::span<const std::byte> rest = *bytes;
  return take_patch(id, rest);
}

Expected<TileMesh> WaveletDecoder::decode(const TileId& id, std::span<const std::byte> bytes) {
  auto made = take_patch(id, bytes);
  if (!made) return tl::unexpected(made.error());
  return decode_right_triangles(bytes, layout_.cells_across(id.level), PatchGuess(layout_, id, **made));
}

Expected<std::optional<PatchResidual>> WaveletDecoder::patch_residual(const TileId& id) {
  const auto own = patch(id);
  if (!own) return tl::unexpected(own.error());
  const auto predicted = prediction(id);
  if (!predicted) return tl::unexpected(predicted.error());
  return make_patch_residual(**own, *predicted);
}

Expected<std::vector<std::byte>> WaveletMesh::encode(const TileMesh&) const {
  return fail(ErrorCode::kUsage, "a tile of method 'wavelet' is coded together with those above it");
}

Expected<TileMesh> WaveletMesh::decode(std::span<const std::byte>) const {
  return fail(ErrorCode::kUsage, "a tile of method 'wavelet' is decoded together with those above it");
}

}  // namespace tintree::codec
