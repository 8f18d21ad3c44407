#include "render/terrain_scene.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cache/patch_lighting.h"
#include "render/nested_lod.h"

namespace tintree::render {
namespace {

/// How far ahead of the camera tiles are fetched, and the most at once.
constexpr double kAhead_s = 1;
constexpr std::size_t kMostAhead = 2048;

/// What the store's tiles are drawn as. A strip or a quantised grid on its way to its parent is a mesh.
cache::Ground ground_of(const cache::TileStore& store, const SceneOptions& options) {
  const cache::Ground native = cache::native_ground_of(store.manifest().method);
  const bool still = native == cache::Ground::kStrip || native == cache::Ground::kScalar;
  return options.cut.morph && still ? cache::Ground::kMesh : native;
}

std::vector<cache::TileCache::Source> sources(TerrainScene::Stores stores, std::span<const PlacedTree> places,
                                              const SceneOptions& options) {
  std::vector<cache::TileCache::Source> out;
  for (std::size_t i = 0; i < stores.size(); ++i) {
    out.push_back({stores[i], places[i].layout, places[i].joined_sides, ground_of(*stores[i], options)});
  }
  return out;
}

/// Whether its tiles are lit by their patches.
bool has_reliefs(const cache::TileStore* store) { return cache::lit_by_patches(store->manifest()); }

bool has(cache::Ground ground, TerrainScene::Stores stores, const SceneOptions& options) {
  return std::ranges::any_of(stores,
                             [&](const cache::TileStore* store) { return ground_of(*store, options) == ground; });
}

/// A half of the graphics memory is for pictures where there are any, a quarter where there are but the normals of
/// strips, a sixteenth where there are but scalar's tables, and a half of that for pictures in leaves; of the rest
/// nested trees have their share.
GpuBudgets budgets(TerrainScene::Stores stores, const SceneOptions& options) {
  const std::size_t gpu_bytes = options.gpu_bytes;
  const bool pictures = std::ranges::any_of(stores, [](const cache::TileStore* store) {
    return store->manifest().texture_size > 0 || store->manifest().normal_maps || has_reliefs(store);
  });
  const std::size_t share = pictures                                       ? gpu_bytes / 2
                            : has(cache::Ground::kStrip, stores, options)  ? gpu_bytes / 4
                            : has(cache::Ground::kScalar, stores, options) ? gpu_bytes / 16
                                                                           : 0;
  const std::size_t rest = gpu_bytes - share;
  const auto fine = static_cast<std::size_t>(
      std::ranges::count_if(stores, [](const cache::TileStore* store) { return store->manifest().texture_depth > 0; }));
  const std::size_t fine_bytes = fine > 0 ? share / 2 : 0;
  const auto nested = static_cast<std::size_t>(std::ranges::count_if(
      stores, [&](const cache::TileStore* store) { return ground_of(*store, options) == cache::Ground::kNested; }));
  // The far ground's picture lies where meshes do: without any it has a share of its own.
  const std::size_t shares = stores.size() + (options.impostors && nested == stores.size() ? 1 : 0);
  const std::size_t nested_bytes = rest / shares * nested;
  return {.mesh_bytes = rest - nested_bytes,
          .picture_bytes = share - fine_bytes,
          .nested_bytes = nested_bytes,
          .fine_texture_bytes = fine_bytes,
          .fine_texture_kinds = fine};
}

}  // namespace

Expected<std::unique_ptr<TerrainScene>> TerrainScene::create(const GlFunctions& gl, Stores stores,
                                                             const SceneOptions& options) {
  std::vector<TreeToPlace> trees;
  for (const cache::TileStore* store : stores) trees.push_back({&store->manifest(), store->path()});
  const auto places = place_trees(trees);
  if (!places) return tl::unexpected(places.error());
  auto renderer = Renderer::create(gl);
  if (!renderer) return tl::unexpected(renderer.error());
  GpuMakers makers;
  if (std::ranges::any_of(stores, has_reliefs)) {
    auto made = PatchReconstructor::create(gl);
    if (!made) return tl::unexpected(made.error());
    makers.reliefs = std::move(*made);
  }
  if (has(cache::Ground::kStrip, stores, options)) {
    auto made = StripUnpacker::create(gl, GpuPages::kLargestPage);
    if (!made) return tl::unexpected(made.error());
    makers.strips = std::move(*made);
  }
  if (has(cache::Ground::kScalar, stores, options)) {
    auto made = ScalarVertices::create(gl);
    if (!made) return tl::unexpected(made.error());
    makers.scalars = std::move(*made);
  }
  std::unique_ptr<FarPicture> far_picture;
  if (options.impostors) {
    auto made = FarPicture::create(gl);
    if (!made) return tl::unexpected(made.error());
    far_picture = std::move(*made);
  }
  return std::unique_ptr<TerrainScene>(
      new TerrainScene(gl, stores, *places, options, std::move(*renderer), std::move(makers), std::move(far_picture)));
}

Expected<std::unique_ptr<TerrainScene>> TerrainScene::create(const GlFunctions& gl, const cache::TileStore& store,
                                                             const SceneOptions& options) {
  const std::array<const cache::TileStore*, 1> one{&store};
  return create(gl, one, options);
}

TerrainScene::TerrainScene(const GlFunctions& gl, Stores stores, std::span<const PlacedTree> places,
                           const SceneOptions& options, Renderer renderer, GpuMakers makers,
                           std::unique_ptr<FarPicture> far_picture)
    : options_(options),
      cache_(std::make_unique<cache::TileCache>(
          sources(stores, places, options),
          cache::TileCache::Options{
              .bytes = options.cache_bytes, .morph = options.cut.morph, .texture_blocks = gl.texture_blocks})),
      pool_(gl, budgets(stores, options), std::move(makers)),
      renderer_(std::move(renderer)),
      far_picture_(std::move(far_picture)) {
  placed_.reserve(stores.size());
  for (std::size_t i = 0; i < stores.size(); ++i) {
    const bool nested = ground_of(*stores[i], options) == cache::Ground::kNested;
    nested_.push_back(nested ? 1 : 0);
    const bool even = nested && options.cut.morph;
    if (i > 0 || even) placed_.push_back(stores[i]->bounds().placed(places[i].layout));
    if (even) placed_.back().raise_errors();
    trees_.push_back(i > 0 || even ? &placed_.back() : &stores[i]->bounds());
  }
}

TileState TerrainScene::state(std::uint32_t tree, std::uint32_t node) {
  // Asking marks as used: what the walk has looked at must not make room before the rest has come.
  const cache::TileRef tile{trees_[tree]->nodes()[node].id, tree};
  if (const GpuTile* here = pool_.use(tile)) {
    if (here->chunk) static_cast<void>(cache_->get(tile));
    return TileState::kResident;
  }
  return cache_->lost(tile) ? TileState::kLost : TileState::kMissing;
}

TextureState TerrainScene::fine_texture(const cache::TileRef& square) {
  if (const auto here = pool_.fine_textures().use(square)) {
    return *here ? TextureState::kResident : TextureState::kNone;
  }
  return cache_->lost(square) ? TextureState::kLost : TextureState::kMissing;
}

std::size_t TerrainScene::take_over(std::vector<cache::TileRef>& wanted) {
  std::vector<cache::TileRef> missing;
  std::size_t moved = 0;
  std::size_t moved_bytes = 0;
  for (const cache::TileRef& ref : wanted) {
    const auto tile = moved_bytes < options_.upload_bytes && !pool_full_ ? cache_->get(ref) : nullptr;
    if (tile == nullptr) {
      missing.push_back(ref);
      continue;
    }
    if (!bring_parent(ref, *tile, missing)) {
      missing.push_back(ref);
      continue;
    }
    const bool fits =
        is_fine_texture(ref) ? pool_.fine_textures().upload(ref, tile->pictures.colors) : pool_.upload(ref, *tile);
    if (!fits) {
      pool_full_ = true;
      continue;
    }
    if (awaited_.erase(ref) == 0) ++stats_.cache_hits;
    ++moved;
    moved_bytes += tile->bytes();
  }
  wanted = std::move(missing);
  stats_.uploads += static_cast<std::uint32_t>(moved);
  stats_.upload_bytes += moved_bytes;
  return moved;
}

bool TerrainScene::bring_parent(const cache::TileRef& ref, const cache::DrawableTile& tile,
                                std::vector<cache::TileRef>& missing) {
  if (!pool_.makes_reliefs() || !tile.relief || !tile.relief->parent) return true;
  const cache::TileRef parent{*tile.relief->parent, ref.tree};
  if (pool_.use(parent) != nullptr || cache_->lost(parent)) return true;
  const auto ready = cache_->get(parent);
  if (ready == nullptr) {
    if (std::ranges::find(missing, parent) == missing.end()) missing.push_back(parent);
    return false;
  }
  // Where it does not fit, the tile has to do without.
  if (bring_parent(parent, *ready, missing) && !pool_.upload(parent, *ready)) pool_full_ = true;
  return pool_full_ || pool_.contains(parent);
}

void TerrainScene::count_misses(std::span<const cache::TileRef> missing) {
  std::unordered_set<cache::TileRef, cache::TileRefHash> awaited;
  for (const cache::TileRef& ref : missing) {
    const bool known = awaited_.contains(ref);
    if (!known && cache_->get(ref) != nullptr) continue;  // It waits for its upload.
    if (!known) ++stats_.cache_misses;
    awaited.insert(ref);
  }
  awaited_ = std::move(awaited);
}

std::vector<cache::TileRef> TerrainScene::tiles_ahead(const Camera& camera, double seconds) {
  trail_.add(seconds, camera);
  std::vector<cache::TileRef> kept;
  const TileStates state = [this](std::uint32_t tree, std::uint32_t node) {
    const cache::TileRef tile{trees_[tree]->nodes()[node].id, tree};
    return pool_.contains(tile) ? TileState::kResident : TileState::kMissing;
  };
  // What has been loaded ahead says whether there are finer ones, and stays where it is.
  const TextureStates texture = [this, &kept](const cache::TileRef& square) {
    if (const auto here = pool_.fine_textures().find(square)) {
      return *here ? TextureState::kResident : TextureState::kNone;
    }
    if (cache_->lost(square)) return TextureState::kLost;
    const auto ready = cache_->peek(square);
    if (ready == nullptr) return TextureState::kMissing;
    kept.push_back(square);
    return ready->pictures.colors.size > 0 ? TextureState::kResident : TextureState::kNone;
  };
  auto out = prefetch(trees_, trail_.ahead(kAhead_s), options_.cut, state, texture, kMostAhead);
  out.insert(out.end(), kept.begin(), kept.end());
  return out;
}

LodCut TerrainScene::advance(const Camera& camera, std::optional<double> seconds) {
  pool_.end_frame();
  pool_full_ = false;
  const OccluderOf occluder_of = [this](std::uint32_t tree, std::uint32_t node) {
    const GpuTile* tile = pool_.use({trees_[tree]->nodes()[node].id, tree});
    return tile != nullptr ? tile->occluder.get() : nullptr;
  };
  CutOptions options = options_.cut;
  if (std::ranges::find(nested_, 1) != nested_.end()) options.off_px = kNestedOff * options.pixel_error;
  const auto choose = [&] {
    LodCut chosen = lod_cut(
        trees_, camera, options, [this](std::uint32_t tree, std::uint32_t node) { return state(tree, node); },
        occlusion_pays_.on(options_.occlusion) ? occluder_of : nullptr);
    add_texture_parts(chosen, trees_, camera, [this](const cache::TileRef& t) { return fine_texture(t); });
    return chosen;
  };
  LodCut cut = choose();
  if (take_over(cut.requests) > 0) cut = choose();
  if (far_picture_ && pool_full_) {
    give_up_far_picture();
    return advance(camera, seconds);
  }
  choose_nested_levels(trees_, camera, nested_, cut);
  occlusion_pays_.note_frame(cut.draws.size(), cut.occluded);
  count_misses(cut.requests);
  std::vector<cache::TileRef> ahead = seconds ? tiles_ahead(camera, *seconds) : std::vector<cache::TileRef>{};
  if (far_picture_) {
    const auto missing = plan_far_picture(camera);
    // Who waits waits for these, too.
    std::vector<cache::TileRef>& list = seconds ? ahead : cut.requests;
    list.insert(seconds ? list.begin() : list.end(), missing.begin(), missing.end());
  }
  cache_->request(cut.requests, ahead);
  return cut;
}

std::vector<cache::TileRef> TerrainScene::plan_far_picture(const Camera& camera) {
  const auto choose = [this](const Camera& from, const CutOptions& options, double beyond_m) {
    const auto is_close = [&](std::uint32_t tree, std::uint32_t node) {
      return nearest_m(trees_[tree]->box(trees_[tree]->nodes()[node]), from.eye) < beyond_m;
    };
    const auto state_beyond = [&](std::uint32_t tree, std::uint32_t node) {
      return is_close(tree, node) ? TileState::kResident : state(tree, node);
    };
    const auto texture_beyond = [&](const cache::TileRef& square) {
      const cache::TileBounds& tree = *trees_[square.tree];
      codec::TileId leaf = square.id;
      while (leaf.level > tree.layout().leaf_level) leaf = tree.layout().parent(leaf);
      const std::int64_t node = tree.find(leaf);
      const bool near = node >= 0 && is_close(square.tree, static_cast<std::uint32_t>(node));
      return near ? TextureState::kNone : fine_texture(square);
    };
    const auto cut = [&] {
      LodCut out = lod_cut(trees_, from, options, state_beyond);
      add_texture_parts(out, trees_, from, texture_beyond);
      return out;
    };
    LodCut chosen = cut();
    if (take_over(chosen.requests) > 0) chosen = cut();
    choose_nested_levels(trees_, from, nested_, chosen);
    return chosen;
  };
  auto missing = far_picture_->plan(camera, trees_, pool_, options_.cut, choose);
  // The view itself has room for its tiles.
  if (std::exchange(pool_full_, false) || !missing) {
    give_up_far_picture();
    return {};
  }
  std::erase_if(*missing, [this](const cache::TileRef& t) { return cache_->lost(t); });
  far_picture_lacks_ = !missing->empty();
  return std::move(*missing);
}

void TerrainScene::give_up_far_picture() {
  far_picture_.reset();
  far_picture_lacks_ = false;
  pool_.set_aside(0);
}

LodCut TerrainScene::update(const Camera& camera, std::optional<double> seconds) {
  stats_ = {};
  LodCut cut = advance(camera, seconds);
  sum_up();
  return cut;
}

void TerrainScene::sum_up() {
  const cache::TileCache::Stats cache = cache_->stats();
  stats_.bytes_read = cache.bytes_read - std::exchange(bytes_read_before_, cache.bytes_read);
  stats_.cache_bytes = cache.bytes;
  stats_.gpu_bytes = pool_.bytes() + (far_picture_ ? far_picture_->bytes() : 0);
  stats_.gpu_memory_full = pool_full_;
}

bool TerrainScene::busy(const LodCut& cut) {
  if (cut.complete) return false;
  if (!cache_->idle()) return true;
  // What has come, or has been lost, since this cut was chosen changes the next.
  return std::ranges::any_of(cut.requests, [this](const cache::TileRef& t) {
    return cache_->lost(t) || (!pool_full_ && cache_->get(t) != nullptr);
  });
}

Expected<LodCut> TerrainScene::settle(const Camera& camera) {
  stats_ = {};
  LodCut cut = advance(camera, std::nullopt);
  while (busy(cut) || far_picture_lacks_) {
    cache_->wait_idle();
    cut = advance(camera, std::nullopt);
  }
  sum_up();
  if (!cut.draws.empty() || cut.wanted == 0) return cut;
  const std::vector<Error> errors = take_errors();
  if (!errors.empty()) return tl::unexpected(errors.front());
  return fail(ErrorCode::kIo,
              "not even the coarsest tile fits into the graphics memory for tiles; allow more with --gpu-memory");
}

DrawStats TerrainScene::draw(const OffscreenTarget& target, const Camera& camera, const LodCut& cut,
                             const Style& style) {
  if (!far_picture_) return renderer_.draw(target, camera, trees_, cut, pool_, style);
  const DrawStats made = far_picture_->refresh(renderer_, trees_, pool_, style, cut.nearest_m);
  LodCut near = cut;
  const std::uint32_t replaced = far_picture_->take_from(near, trees_, camera);
  renderer_.draw_background(target, camera, style);
  if (replaced > 0) far_picture_->draw(camera, renderer_.near_m(cut));
  DrawStats drawn = renderer_.draw_ground(camera, trees_, near, pool_, style);
  drawn.impostor_tiles = replaced;
  drawn.impostor_triangles = made.triangles;
  return drawn;
}

}  // namespace tintree::render
