#include "cache/tile_cache.h"

#include <exception>
#include <utility>

#include "cache/morph.h"

namespace tintree::cache {
namespace {

struct Loaded {
  std::shared_ptr<DrawableTile> tile;
  std::size_t payload_bytes = 0;
};

Expected<Loaded> load(const TileStore& store, const codec::TileId& id) {
  auto stored = store.read(id);
  if (!stored) return tl::unexpected(stored.error());
  auto mesh = decode_tile(store.manifest(), *stored);
  if (!mesh) {
    mesh.error().where = store.path() + ": " + mesh.error().where;
    return tl::unexpected(mesh.error());
  }
  const codec::TreeLayout& layout = store.manifest().layout;
  return Loaded{std::make_shared<DrawableTile>(make_drawable(layout, id, *mesh)), stored->payload.size()};
}

/// Makes a tile ready to turn into its parent, which is read too where it is not at hand.
Expected<void> add_morph(const TileStore& store, std::shared_ptr<const DrawableTile> parent, Loaded& loaded) {
  if (parent == nullptr) {
    auto read = load(store, loaded.tile->id.parent());
    if (!read) return tl::unexpected(read.error());
    loaded.payload_bytes += read->payload_bytes;
    parent = std::move(read->tile);
  }
  loaded.tile->morph = make_morph(*loaded.tile, *parent);
  return {};
}

Expected<Loaded> prepare(const TileStore& store, const codec::TileId& id, bool morph,
                         const std::shared_ptr<const DrawableTile>& parent) try {
  auto loaded = load(store, id);
  // A tile whose parent is damaged can still be drawn.
  if (loaded && morph && id.level > 0) static_cast<void>(add_morph(store, parent, *loaded));
  return loaded;
} catch (const std::exception& e) {
  return fail(ErrorCode::kIo, "tile " + id.text() + " could not be loaded: " + e.what(), store.path());
}

}  // namespace

TileCache::TileCache(const TileStore& store, const Options& options)
    : store_(store), options_(options), worker_([this] { work(); }) {}

TileCache::~TileCache() {
  {
    const std::scoped_lock lock(turn_);
    stop_ = true;
    queue_.clear();
  }
  asked_.notify_all();
  worker_.join();
}

std::shared_ptr<const DrawableTile> TileCache::get(const codec::TileId& id) {
  const std::scoped_lock lock(turn_);
  const auto at = by_key_.find(id.key());
  if (at == by_key_.end()) return nullptr;
  touch(at->second);
  return at->second->tile;
}

void TileCache::request(std::span<const codec::TileId> most_urgent_first) {
  {
    const std::scoped_lock lock(turn_);
    ++round_;
    queue_.clear();
    for (const codec::TileId& id : most_urgent_first) {
      const std::int64_t key = id.key();
      if (const auto at = by_key_.find(key); at != by_key_.end()) {
        touch(at->second);
      } else if (!failed_.contains(key) && !(busy_ && in_work_ == id)) {
        queue_.push_back(id);
      }
    }
    evict();
  }
  asked_.notify_one();
}

bool TileCache::idle() const {
  const std::scoped_lock lock(turn_);
  return queue_.empty() && !busy_;
}

void TileCache::wait_idle() {
  std::unique_lock lock(turn_);
  rested_.wait(lock, [this] { return queue_.empty() && !busy_; });
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
    asked_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    const codec::TileId id = queue_.front();
    queue_.pop_front();
    if (by_key_.contains(id.key()) || failed_.contains(id.key())) {
      if (queue_.empty()) rested_.notify_all();
      continue;
    }
    in_work_ = id;
    busy_ = true;
    const auto at = id.level > 0 ? by_key_.find(id.parent().key()) : by_key_.end();
    const auto parent = at != by_key_.end() ? at->second->tile : nullptr;
    lock.unlock();
    auto loaded = prepare(store_, id, options_.morph, parent);
    lock.lock();
    busy_ = false;
    if (loaded) {
      stats_.bytes_read += loaded->payload_bytes;
      keep(std::move(loaded->tile));
    } else {
      failed_.insert(id.key());
      errors_.push_back(std::move(loaded.error()));
    }
    if (queue_.empty()) rested_.notify_all();
  }
}

void TileCache::keep(std::shared_ptr<const DrawableTile> tile) {
  stats_.bytes += tile->bytes();
  ++stats_.tiles;
  ++stats_.loaded;
  const std::int64_t key = tile->id.key();
  entries_.push_front({std::move(tile), round_});
  by_key_[key] = entries_.begin();
  evict();
}

void TileCache::touch(Entries::iterator entry) {
  entry->round = round_;
  entries_.splice(entries_.begin(), entries_, entry);
}

void TileCache::evict() {
  while (stats_.bytes > options_.bytes && !entries_.empty() && entries_.back().round + 1 < round_) {
    const DrawableTile& oldest = *entries_.back().tile;
    stats_.bytes -= oldest.bytes();
    --stats_.tiles;
    ++stats_.evicted;
    by_key_.erase(oldest.id.key());
    entries_.pop_back();
  }
}

}  // namespace tintree::cache
