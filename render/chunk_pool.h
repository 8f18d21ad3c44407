#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace tintree::render {

/// Graphics memory in chunks whose sizes double, which are never cut or joined, so that it does not fragment (Schneider
/// and Westermann 2006, section 6). Chunks are made as they are needed, up to a budget. Decides only: the memory is the
/// caller's. Not thread-safe. Cost: linear in the number of chunks.
class ChunkPool {
 public:
  /// Sizes are `smallest` and its doubles.
  ChunkPool(std::size_t budget, std::size_t smallest) : budget_(budget), smallest_(smallest) {}

  struct Chunk {
    std::size_t size = 0;  ///< 0: it has been given up, and its number is free.
    std::optional<std::uint64_t> owner;
    std::uint64_t used = 0;  ///< The frame that used it last.
  };
  const std::vector<Chunk>& chunks() const { return chunks_; }
  /// Of all chunks; never more than the budget.
  std::size_t bytes() const { return bytes_; }

  /// A chunk of at least `size` for `owner`, marked as used in `frame`: an empty or a new one of the size that fits
  /// tightest; else the smallest empty one that holds it; else, of those not used in this frame, the one with the most
  /// frames since its last use for each time that it is larger than needed (least recently used, weighed against
  /// tightest fit); else a new one in place of the least recently used smaller ones. Its number, or nothing when this
  /// frame's chunks leave no room. Owners whose chunks have gone come behind `put_out`.
  std::optional<std::size_t> take(std::uint64_t owner, std::size_t size, std::uint64_t frame,
                                  std::vector<std::uint64_t>& put_out);
  void use(std::size_t chunk, std::uint64_t frame) { chunks_[chunk].used = frame; }
  void give_back(std::size_t chunk) { chunks_[chunk].owner.reset(); }

 private:
  std::optional<std::size_t> smallest_empty(std::size_t size) const;
  std::optional<std::size_t> least_missed(std::size_t size, std::uint64_t frame) const;
  bool give_up_oldest(std::uint64_t frame, std::vector<std::uint64_t>& put_out);
  std::size_t make(std::size_t size);

  std::size_t budget_;
  std::size_t smallest_;
  std::size_t bytes_ = 0;
  std::vector<Chunk> chunks_;
};

}  // namespace tintree::render
