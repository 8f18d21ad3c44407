#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace tintree::render {

/// Graphics memory in chunks whose sizes double, which are never cut or joined, so that it does not fragment (Schneider
/// and Westermann 2006, section 6). Each size has an equal share of the budget, one chunk at least. Decides only: where
/// the chunks lie is the caller's. Not thread-safe. Cost: linear in the number of chunks.
class ChunkPool {
 public:
  /// Sizes are `smallest` and its doubles up to the first that holds `largest`.
  ChunkPool(std::size_t budget, std::size_t smallest, std::size_t largest);

  struct Chunk {
    std::size_t size = 0;
    std::size_t begin = 0;  ///< Chunks lie one behind the other.
    std::optional<std::uint64_t> owner;
    std::uint64_t used = 0;  ///< The frame that used it last.
  };
  const std::vector<Chunk>& chunks() const { return chunks_; }
  /// Of all chunks.
  std::size_t bytes() const { return chunks_.empty() ? 0 : chunks_.back().begin + chunks_.back().size; }

  /// A chunk of at least `size` for `owner`, marked as used in `frame`: the smallest empty one that does; else, of
  /// those not used in this frame, the one with the most frames since its last use for each time that it is larger than
  /// needed (least recently used, weighed against tightest fit). Its index, or nothing when there is none.
  std::optional<std::size_t> take(std::uint64_t owner, std::size_t size, std::uint64_t frame);
  void use(std::size_t chunk, std::uint64_t frame) { chunks_[chunk].used = frame; }
  void give_back(std::size_t chunk) { chunks_[chunk].owner.reset(); }

 private:
  std::vector<Chunk> chunks_;  // small ones first
};

}  // namespace tintree::render
