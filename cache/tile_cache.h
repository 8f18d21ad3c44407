#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cache/drawable_tile.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/tile_id.h"

namespace tintree::cache {

/// The caching thread (Wahl et al. 2004, section 5, Caching): reads, verifies, decodes and prepares the
/// tiles that a view asks for while the view goes on drawing.
///
/// Thread-safety: one thread, the view's, constructs, asks and destroys; the object's own thread does the
/// work. All members may nevertheless be called from any thread; none but wait_idle() and the destructor
/// (which ends the tile in work, a few milliseconds) ever waits for a read or a decode. A returned tile is
/// immutable and stays alive as long as somebody holds it.
class TileCache {
 public:
  struct Options {
    /// Memory for prepared tiles. The least recently used leave first; the tiles of the view's last two
    /// request() rounds never leave, so that a view which needs more than this gets it all the same.
    std::size_t bytes = std::size_t{256} << 20;
    bool morph = false;  ///< Tiles come with DrawableTile::morph: five times the memory, three times the time.
  };

  struct Stats {
    std::size_t bytes = 0;         ///< Held now.
    std::size_t tiles = 0;         ///< Held now.
    std::uint64_t loaded = 0;      ///< Tiles prepared so far.
    std::uint64_t evicted = 0;     ///< Tiles dropped so far.
    std::uint64_t bytes_read = 0;  ///< Payload bytes read so far.
  };

  /// `store` must outlive the cache.
  TileCache(const TileStore& store, const Options& options);
  ~TileCache();
  TileCache(const TileCache&) = delete;
  TileCache& operator=(const TileCache&) = delete;

  /// The tile if it is here, else null. Does not ask for it.
  std::shared_ptr<const DrawableTile> get(const codec::TileId& id);

  /// Asks for these tiles, the most urgent first, in place of all that was asked before and has not begun.
  /// A view calls this once a frame with what it misses (and behind it what it may want next). Tiles that
  /// are here are kept; tiles that have failed before are left out.
  void request(std::span<const codec::TileId> most_urgent_first);

  /// True when nothing is asked for and nothing in work.
  bool idle() const;
  /// Waits until idle().
  void wait_idle();

  /// The failures since the last call: each tile's once, with the file and the tile named.
  std::vector<Error> take_errors();
  Stats stats() const;

 private:
  struct Entry {
    std::shared_ptr<const DrawableTile> tile;
    std::uint64_t round = 0;  ///< The request() round that last used it.
  };
  using Entries = std::list<Entry>;

  void work();
  void keep(std::shared_ptr<const DrawableTile> tile);
  void evict();
  /// Makes it the most recently used.
  void touch(Entries::iterator entry);

  const TileStore& store_;
  const Options options_;

  mutable std::mutex turn_;  ///< Guards all that follows.
  std::condition_variable asked_;
  std::condition_variable rested_;
  std::deque<codec::TileId> queue_;
  Entries entries_;  ///< The most recently used first.
  std::unordered_map<std::int64_t, Entries::iterator> by_key_;
  std::unordered_set<std::int64_t> failed_;
  std::vector<Error> errors_;
  Stats stats_;
  std::uint64_t round_ = 0;
  bool busy_ = false;
  bool stop_ = false;
  codec::TileId in_work_;

  std::thread worker_;  ///< Last, so that it starts when all else is there.
};

}  // namespace tintree::cache
