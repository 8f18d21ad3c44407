#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cache/drawable_tile.h"
#include "cache/tile_ref.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// The caching thread (Wahl et al. 2004, section 5, Caching & Prefetching): reads, verifies, decodes and
/// prepares the tiles that a view asks for while the view goes on drawing.
///
/// Thread-safety: one thread, the view's, constructs, asks and destroys; the object's own thread does the
/// work. All members may nevertheless be called from any thread; none but wait_idle() and the destructor
/// (which ends the tile in work, a few milliseconds) ever waits for a read or a decode. A returned tile is
/// immutable and stays alive as long as somebody holds it.
class TileCache {
 public:
  /// One tree to take tiles from.
  struct Source {
    const TileStore* store = nullptr;  ///< Must outlive the cache.
    codec::TreeLayout layout;          ///< Where the tree lies in the scene; the store's own for a tree by itself.
    std::uint16_t joined_sides = 0;    ///< As make_drawable() takes them.
    Ground ground = Ground::kMesh;     ///< Tiles come with DrawableTile::native of that kind where they can.
  };

  struct Options {
    /// Memory for prepared tiles. The least recently used leave first; the tiles that the view's last two
    /// request() rounds needed never leave, so that a view which needs more than this gets it all the same.
    std::size_t bytes = std::size_t{256} << 20;
    bool morph = false;  ///< Tiles come with DrawableTile::morph: five times the memory, three times the time.
    /// The most requests that wait; the least urgent beyond are dropped, to be asked for again.
    std::size_t queue = 1024;
    /// The card takes BC1 textures as they are; else they are unpacked here.
    bool texture_blocks = true;
  };

  struct Stats {
    std::size_t bytes = 0;         ///< Held now.
    std::size_t tiles = 0;         ///< Held now.
    std::uint64_t loaded = 0;      ///< Tiles prepared so far.
    std::uint64_t ahead = 0;       ///< Those of them that were loaded ahead of need.
    std::uint64_t evicted = 0;     ///< Tiles dropped so far.
    std::uint64_t bytes_read = 0;  ///< Payload bytes read so far.
    std::uint64_t lost = 0;        ///< Tiles that could not be loaded.
  };

  TileCache(std::vector<Source> trees, const Options& options);
  /// A single tree.
  TileCache(const TileStore& store, const Options& options);
  ~TileCache();
  TileCache(const TileCache&) = delete;
  TileCache& operator=(const TileCache&) = delete;

  /// The tile if it is here, else null. Does not ask for it.
  std::shared_ptr<const DrawableTile> get(const TileRef& tile);
  /// The same, without taking it for needed.
  std::shared_ptr<const DrawableTile> peek(const TileRef& tile) const;

  /// Asks for these tiles, the most urgent first, in place of all that was asked before and has not begun. A view
  /// calls this once a frame with what it misses (`needed`) and what it may want next (`ahead`), which is
  /// loaded after that and only while it fits into Options::bytes together with what is needed. Tiles that are here are
  /// kept; tiles that have failed before are left out.
  void request(std::span<const TileRef> needed, std::span<const TileRef> ahead = {});

  /// True when nothing needed is asked for or in work.
  bool idle() const;
  /// Waits until idle().
  void wait_idle();

  /// Whether the tile could not be loaded, and never will be.
  bool lost(const TileRef& tile) const;
  /// The failures since the last call, with the file and the tile named: each tile's once, and what befell a file as a
  /// whole (it was cut short, the disk is gone) once for all of its tiles.
  std::vector<Error> take_errors();
  Stats stats() const;

 private:
  struct Entry {
    TileRef ref;
    std::shared_ptr<const DrawableTile> tile;
    std::uint64_t needed = 0;  ///< The request() round that last needed it,
    std::uint64_t wanted = 0;  ///< or last named it at all.
  };
  using Entries = std::list<Entry>;
  struct Job {
    TileRef ref;
    bool needed = true;
  };

  void work();
  void enqueue(const TileRef& tile, bool needed);
  void finish(const Job& job, std::shared_ptr<const DrawableTile> tile);
  bool busy_with_needed() const;
  /// What is wanted fills the memory: until the view asks anew.
  void load_no_more_ahead();
  /// Drops the least recently used down to the budget less `room`, of what is not `needed` or, for tiles loaded
  /// ahead, not wanted either. True when that is reached.
  bool make_room(std::size_t room, std::uint64_t Entry::*round);
  /// Makes it the most recently used.
  void touch(Entries::iterator entry, bool needed);

  const std::vector<Source> trees_;
  const Options options_;

  mutable std::mutex turn_;  ///< Guards all that follows.
  std::condition_variable asked_;
  std::condition_variable rested_;
  std::deque<Job> queue_;  ///< What is needed, then what is loaded ahead.
  Entries entries_;        ///< The most recently used first.
  std::unordered_map<TileRef, Entries::iterator, TileRefHash> by_ref_;
  std::unordered_set<TileRef, TileRefHash> lost_;
  std::vector<Error> errors_;
  std::unordered_set<std::string> told_;  ///< All errors so far.
  Stats stats_;
  std::uint64_t round_ = 2;  ///< So that what no round has named is older than two rounds.
  bool busy_ = false;
  bool stop_ = false;
  Job in_work_;

  std::thread worker_;  ///< Last, so that it starts when all else is there.
};

}  // namespace tintree::cache
