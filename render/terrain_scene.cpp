#include "render/terrain_scene.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tintree::render {

Expected<std::unique_ptr<TerrainScene>> TerrainScene::create(const GlFunctions& gl, const cache::TileStore& store,
                                                             const SceneOptions& options) {
  auto renderer = Renderer::create(gl);
  if (!renderer) return tl::unexpected(renderer.error());
  return std::unique_ptr<TerrainScene>(new TerrainScene(gl, store, options, std::move(*renderer)));
}

TerrainScene::TerrainScene(const GlFunctions& gl, const cache::TileStore& store, const SceneOptions& options,
                           Renderer renderer)
    : store_(&store),
      options_(options),
      cache_(store, {options.cache_bytes}),
      pool_(gl, options.gpu_bytes),
      renderer_(std::move(renderer)) {}

LodCut TerrainScene::choose(const Camera& camera) {
  // Asking marks as used: what the walk has looked at must not be freed before the rest has come.
  return lod_cut(bounds(), camera, options_.cut,
                 [this](std::uint32_t node) { return pool_.use(bounds().nodes()[node].id) != nullptr; });
}

std::size_t TerrainScene::take_over(std::vector<codec::TileId>& wanted) {
  std::vector<codec::TileId> missing;
  std::size_t moved = 0;
  std::size_t moved_bytes = 0;
  for (const codec::TileId& id : wanted) {
    const auto tile = moved_bytes < options_.upload_bytes ? cache_.get(id) : nullptr;
    if (tile == nullptr) {
      missing.push_back(id);
      if (awaited_.insert(id.key()).second) ++stats_.cache_misses;
      continue;
    }
    if (awaited_.erase(id.key()) == 0) ++stats_.cache_hits;
    pool_.upload(*tile);
    ++moved;
    moved_bytes += tile->bytes();
  }
  wanted = std::move(missing);
  stats_.uploads += static_cast<std::uint32_t>(moved);
  stats_.upload_bytes += moved_bytes;
  return moved;
}

LodCut TerrainScene::update(const Camera& camera) {
  stats_ = {};
  LodCut cut = advance(camera);
  const cache::TileCache::Stats cache = cache_.stats();
  stats_.bytes_read = cache.bytes_read - std::exchange(bytes_read_before_, cache.bytes_read);
  stats_.cache_bytes = cache.bytes;
  stats_.gpu_bytes = pool_.bytes();
  return cut;
}

LodCut TerrainScene::advance(const Camera& camera) {
  pool_.end_frame();
  LodCut cut = choose(camera);
  if (take_over(cut.requests) > 0) cut = choose(camera);
  cache_.request(cut.requests);
  return cut;
}

Expected<LodCut> TerrainScene::settle(const Camera& camera) {
  while (true) {
    LodCut cut = update(camera);
    if (cut.complete && cut.requests.empty()) return cut;
    cache_.wait_idle();
    const std::vector<Error> errors = cache_.take_errors();
    if (!errors.empty()) return tl::unexpected(errors.front());
    if (std::ranges::none_of(cut.requests, [this](const codec::TileId& id) { return cache_.get(id) != nullptr; })) {
      return fail(ErrorCode::kBadData, "tile " + cut.requests.front().text() + " could not be loaded", store_->path());
    }
  }
}

DrawStats TerrainScene::draw(const OffscreenTarget& target, const Camera& camera, const LodCut& cut,
                             const Style& style) {
  return renderer_.draw(target, camera, bounds(), cut, pool_, style);
}

}  // namespace tintree::render
