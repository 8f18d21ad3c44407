#include "apps/build/plan_pictures.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <vector>

#include "simplify/picture_layer.h"
#include "simplify/picture_pyramid.h"
#include "simplify/reference_surface.h"
#include "simplify/stored_tile.h"

namespace tintree::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSampled = 8;

struct Leaves {
  std::vector<codec::TileId> sampled;  ///< Evenly spread.
  std::uint64_t pictures = 0;          ///< Of all levels.
};

/// `leaves`: those without finer pictures, `pictures`: all.
Leaves choose_leaves(const std::vector<codec::TileId>& leaves, std::uint64_t pictures) {
  Leaves out{{}, pictures};
  const std::size_t count = std::min(kSampled, leaves.size());
  for (std::size_t i = 0; i < count; ++i) out.sampled.push_back(leaves[(2 * i + 1) * leaves.size() / (2 * count)]);
  return out;
}

Leaves choose_texture_leaves(const cache::Manifest& manifest, const simplify::PictureLayer& layer) {
  std::vector<codec::TileId> leaves;
  std::uint64_t pictures = 0;
  const auto levels =
      simplify::list_pictures(cache::PictureKind::kTexture, manifest, layer, simplify::list_tiles(manifest.layout));
  for (const auto& level : levels) {
    pictures += level.size();
    std::ranges::copy_if(level, std::back_inserter(leaves),
                         [&layer](const codec::TileId& id) { return !layer.has_finer(id); });
  }
  return choose_leaves(leaves, pictures);
}

Leaves choose_normal_leaves(const codec::TreeLayout& layout) {
  std::vector<codec::TileId> all = simplify::list_tiles(layout);
  std::erase_if(all, [&layout](const codec::TileId& id) { return id != layout.picture_tile(id); });
  const std::uint64_t pictures = all.size();
  std::erase_if(all, [&layout](const codec::TileId& id) { return !layout.is_leaf_square(id.level); });
  return choose_leaves(all, pictures);
}

/// Makes the sampled pictures and scales what they come to up to all.
Expected<PicturePlan> judge(simplify::PictureLayer& layer, const Leaves& leaves) {
  const auto begun = Clock::now();
  std::vector<std::uint64_t> sizes;
  std::uint64_t sum = 0;
  for (const codec::TileId& id : leaves.sampled) {
    const auto values = layer.make_leaf(id);
    if (!values) return tl::unexpected(values.error());
    const auto payload = layer.encode(*values);
    if (!payload) return tl::unexpected(payload.error());
    if (!payload->empty()) sizes.push_back(payload->size());
    sum += payload->size();
  }
  PicturePlan plan;
  const auto sampled = static_cast<double>(leaves.sampled.size());
  const double factor = static_cast<double>(leaves.pictures) / sampled;
  plan.make_seconds = std::chrono::duration<double>(Clock::now() - begun).count() * factor;
  plan.pictures = static_cast<std::uint64_t>(static_cast<double>(sizes.size()) * factor);
  plan.bytes = static_cast<std::uint64_t>(static_cast<double>(sum) * factor);
  for (std::uint64_t i = 0; i < plan.pictures; ++i) plan.size.add(sizes[i % sizes.size()]);
  return plan;
}

}  // namespace

Expected<PicturePlan> plan_textures(const cache::Manifest& manifest, const std::optional<cache::OrthoSource>& photos) {
  if (!photos) return PicturePlan{};
  const auto layer = simplify::make_texture_layer(manifest, *photos);
  return judge(*layer, choose_texture_leaves(manifest, *layer));
}

Expected<PicturePlan> plan_normals(const cache::Manifest& manifest, const std::shared_ptr<cache::HeightBlocks>& blocks,
                                   const StopFlag* stop) {
  if (!manifest.normal_maps) return PicturePlan{};
  const Leaves leaves = choose_normal_leaves(manifest.layout);
  std::vector<codec::CellRect> windows;
  for (const codec::TileId& id : leaves.sampled) windows.push_back(manifest.layout.cells(id));
  const auto surface = simplify::ReferenceSurface::scan_windows(blocks, windows, stop);
  if (!surface) return tl::unexpected(surface.error());
  return judge(*simplify::make_normal_layer(manifest, **surface, stop), leaves);
}

}  // namespace tintree::app
