#include "cache/tile_cache.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "cache/morph.h"
#include "cache/patch_lighting.h"
#include "codec/coded_strip_mesh.h"

namespace tintree::cache {
namespace {

struct Loaded {
  std::shared_ptr<DrawableTile> tile;
  codec::TileMesh mesh;
  std::size_t payload_bytes = 0;
};

using Parent = std::shared_ptr<const DrawableTile>;

Expected<Loaded> load(const TileCache::Source& tree, const codec::TileId& id, Parent parent);

/// The parent, which is read where it is not at hand.
Expected<Parent> find_parent(const TileCache::Source& tree, const codec::TileId& id, Parent at_hand, Loaded& loaded) {
  if (at_hand != nullptr) return at_hand;
  auto read = load(tree, tree.layout.parent(id), nullptr);
  if (!read) return tl::unexpected(read.error());
  loaded.payload_bytes += read->payload_bytes;
  return std::move(read->tile);
}

/// Nested levels, the coarser ones from the parent's if it is not damaged.
void add_nested(const TileCache::Source& tree, const StoredTile& stored, Parent parent, Loaded& loaded) {
  const codec::TileId& id = loaded.tile->id;
  if (!can_have_nested_shape(tree.layout, id, loaded.mesh)) return;
  if (id.level > 0) parent = find_parent(tree, id, std::move(parent), loaded).value_or(nullptr);
  const NestedShape* above = id.level > 0 && parent != nullptr ? parent->native.nested.get() : nullptr;
  loaded.tile->native.nested = std::make_shared<const NestedShape>(make_nested_shape(
      tree.layout, id, loaded.mesh, *loaded.tile, stored.info.lod_error_m(), tree.joined_sides, above));
}

Expected<Loaded> load(const TileCache::Source& tree, const codec::TileId& id, Parent parent) {
  auto stored = tree.store->read(id);
  if (!stored) return tl::unexpected(stored.error());
  const std::size_t payload_bytes = stored->payload.size();
  if (tree.ground == Ground::kStrip) {
    // Of a damaged one decode() tells what is wrong.
    if (auto packed = codec::packed_strip(stored->payload)) stored->payload = std::move(*packed);
  }
  auto mesh = tree.store->decode(*stored);
  if (!mesh) {
    mesh.error().where = tree.store->path() + ": " + mesh.error().where;
    return tl::unexpected(mesh.error());
  }
  std::shared_ptr<DrawableTile> tile;
  if (tree.ground == Ground::kStrip)
    tile = make_drawable_strip(tree.layout, id, std::move(stored->payload), *mesh, tree.joined_sides);
  if (tree.ground == Ground::kScalar) tile = make_drawable_quantized(tree.layout, id, *mesh, tree.joined_sides);
  if (tile == nullptr) tile = std::make_shared<DrawableTile>(make_drawable(tree.layout, id, *mesh, tree.joined_sides));
  Loaded out{std::move(tile), std::move(*mesh), payload_bytes};
  if (tree.ground == Ground::kNested) add_nested(tree, *stored, std::move(parent), out);
  return out;
}

Expected<void> add_pictures(const TileCache::Source& tree, bool texture_blocks, Loaded& loaded) {
  auto pictures = load_pictures(*tree.store, loaded.tile->id, texture_blocks);
  if (!pictures) return tl::unexpected(pictures.error());
  loaded.tile->pictures = std::move(*pictures);
  loaded.payload_bytes += loaded.tile->pictures.bytes();
  return {};
}

/// What a tile is lit by where its patch does that.
Expected<void> add_relief(const TileCache::Source& tree, Loaded& loaded) {
  if (!lit_by_patches(tree.store->manifest())) return {};
  auto residual = tree.store->patch_residual(loaded.tile->id);
  if (!residual) return tl::unexpected(residual.error());
  if (*residual)
    loaded.tile->relief = make_tile_relief(tree.layout, loaded.tile->id, loaded.mesh, std::move(**residual));
  return {};
}

/// Makes a tile ready to turn into its parent.
Expected<void> add_morph(const TileCache::Source& tree, Parent parent, Loaded& loaded) {
  const auto found = find_parent(tree, loaded.tile->id, std::move(parent), loaded);
  if (!found) return tl::unexpected(found.error());
  loaded.tile->morph = make_morph(*loaded.tile, **found);
  return {};
}

/// A finer texture on a square in a leaf.
Expected<Loaded> load_texture(const TileCache::Source& tree, const codec::TileId& id, bool texture_blocks) {
  Loaded out{std::make_shared<DrawableTile>(), {}, 0};
  out.tile->id = id;
  if (auto done = add_pictures(tree, texture_blocks, out); !done) return tl::unexpected(done.error());
  return out;
}

Expected<Loaded> prepare(const TileCache::Source& tree, const codec::TileId& id, const TileCache::Options& options,
                         const Parent& parent) try {
  if (id.level > tree.layout.leaf_level) return load_texture(tree, id, options.texture_blocks);
  auto loaded = load(tree, id, parent);
  if (!loaded) return loaded;
  if (auto done = add_pictures(tree, options.texture_blocks, *loaded); !done) return tl::unexpected(done.error());
  if (auto done = add_relief(tree, *loaded); !done) return tl::unexpected(done.error());
  // A tile whose parent is damaged can still be drawn.
  const bool morph = options.morph && id.level > 0 && !loaded->tile->native.is_there();
  if (morph) static_cast<void>(add_morph(tree, parent, *loaded));
  return loaded;
} catch (const std::exception& e) {
  return fail(ErrorCode::kIo, "tile " + id.text() + " could not be loaded: " + e.what(), tree.store->path());
}

}  // namespace

TileCache::TileCache(std::vector<Source> trees, const Options& options)
    : trees_(std::move(trees)), options_(options), worker_([this] { work(); }) {}

TileCache::TileCache(const TileStore& store, const Options& options)
    : TileCache(std::vector<Source>{{&store, store.manifest().layout, 0}}, options) {}

TileCache::~TileCache() {
  {
    const std::scoped_lock lock(turn_);
    stop_ = true;
    queue_.clear();
  }
  asked_.notify_all();
  worker_.join();
}

std::shared_ptr<const DrawableTile> TileCache::get(const TileRef& tile) {
  const std::scoped_lock lock(turn_);
  const auto at = by_ref_.find(tile);
  if (at == by_ref_.end()) return nullptr;
  touch(at->second, true);
  return at->second->tile;
}

std::shared_ptr<const DrawableTile> TileCache::peek(const TileRef& tile) const {
  const std::scoped_lock lock(turn_);
  const auto at = by_ref_.find(tile);
  return at != by_ref_.end() ? at->second->tile : nullptr;
}

void TileCache::request(std::span<const TileRef> needed, std::span<const TileRef> ahead) {
  {
    const std::scoped_lock lock(turn_);
    ++round_;
    queue_.clear();
    // In reverse for the order of use: what is most urgent leaves last.
    std::for_each(ahead.rbegin(), ahead.rend(), [&](const TileRef& tile) {
      if (const auto at = by_ref_.find(tile); at != by_ref_.end()) touch(at->second, false);
    });
    for (const TileRef& tile : needed) enqueue(tile, true);
    for (const TileRef& tile : ahead) enqueue(tile, false);
    make_room(0, &Entry::needed);
  }
  asked_.notify_one();
}

void TileCache::enqueue(const TileRef& tile, bool needed) {
  if (const auto at = by_ref_.find(tile); at != by_ref_.end()) {
    if (needed) touch(at->second, true);
    return;
  }
  if (busy_ && in_work_.ref == tile) {
    in_work_.needed = in_work_.needed || needed;
  } else if (queue_.size() < options_.queue && !lost_.contains(tile)) {
    queue_.push_back({tile, needed});
  }
}

bool TileCache::busy_with_needed() const {
  return (busy_ && in_work_.needed) || (!queue_.empty() && queue_.front().needed);
}

bool TileCache::idle() const {
  const std::scoped_lock lock(turn_);
  return !busy_with_needed();
}

void TileCache::wait_idle() {
  std::unique_lock lock(turn_);
  rested_.wait(lock, [this] { return !busy_with_needed(); });
}

bool TileCache::lost(const TileRef& tile) const {
  const std::scoped_lock lock(turn_);
  return lost_.contains(tile);
}

std::vector<Error> TileCache::take_errors() {
  const std::scoped_lock lock(turn_);
  return std::exchange(errors_, {});
}

TileCache::Stats TileCache::stats() const {
  const std::scoped_lock lock(turn_);
  return stats_;
}

void TileCache::work() {
  std::unique_lock lock(turn_);
  while (true) {
    if (!busy_with_needed()) rested_.notify_all();
    asked_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    const Job job = queue_.front();
    queue_.pop_front();
    if (by_ref_.contains(job.ref) || lost_.contains(job.ref)) continue;
    const std::size_t usual_bytes = stats_.bytes / std::max<std::size_t>(stats_.tiles, 1);
    if (!job.needed && !make_room(usual_bytes, &Entry::wanted)) {
      load_no_more_ahead();
      continue;
    }
    in_work_ = job;
    busy_ = true;
    const codec::TileId& id = job.ref.id;
    const auto at = id.level > 0 ? by_ref_.find({trees_[job.ref.tree].layout.parent(id), job.ref.tree}) : by_ref_.end();
    const auto parent = at != by_ref_.end() ? at->second->tile : nullptr;
    lock.unlock();
    auto loaded = prepare(trees_[job.ref.tree], id, options_, parent);
    lock.lock();
    busy_ = false;
    if (loaded) {
      stats_.bytes_read += loaded->payload_bytes;
      finish(in_work_, std::move(loaded->tile));
    } else {
      lost_.insert(job.ref);
      ++stats_.lost;
      if (told_.insert(loaded.error().text()).second) errors_.push_back(std::move(loaded.error()));
    }
  }
}

void TileCache::finish(const Job& job, std::shared_ptr<const DrawableTile> tile) {
  const std::size_t bytes = tile->bytes();
  if (!make_room(bytes, job.needed ? &Entry::needed : &Entry::wanted) && !job.needed) {
    load_no_more_ahead();
    return;
  }
  stats_.bytes += bytes;
  ++stats_.tiles;
  ++stats_.loaded;
  stats_.ahead += job.needed ? 0U : 1U;
  entries_.push_front({job.ref, std::move(tile), job.needed ? round_ : 0, round_});
  by_ref_[job.ref] = entries_.begin();
}

void TileCache::load_no_more_ahead() {
  std::erase_if(queue_, [](const Job& j) { return !j.needed; });
}

void TileCache::touch(Entries::iterator entry, bool needed) {
  entry->wanted = round_;
  if (needed) entry->needed = round_;
  entries_.splice(entries_.begin(), entries_, entry);
}

bool TileCache::make_room(std::size_t room, std::uint64_t Entry::*round) {
  for (auto at = entries_.end(); stats_.bytes + room > options_.bytes && at != entries_.begin();) {
    --at;
    if ((*at).*round + 1 >= round_) continue;
    stats_.bytes -= at->tile->bytes();
    --stats_.tiles;
    ++stats_.evicted;
    by_ref_.erase(at->ref);
    at = entries_.erase(at);
  }
  return stats_.bytes + room <= options_.bytes;
}

}  // namespace tintree::cache
