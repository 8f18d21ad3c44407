#pragma once

#include <cstddef>
#include <map>
#include <optional>

namespace tintree::render {

/// Hands out ranges of one block of `size` units, the first that fits, and joins what comes back with its
/// neighbours. Not thread-safe. Cost: linear in the number of gaps.
class RangeAllocator {
 public:
  explicit RangeAllocator(std::size_t size) : size_(size) { gaps_[0] = size; }

  /// Where a range of `size` > 0 units begins; nothing when no gap is so long.
  std::optional<std::size_t> take(std::size_t size);
  /// Gives back a range as take() gave it.
  void give(std::size_t begin, std::size_t size);

  std::size_t size() const { return size_; }
  /// Whether nothing is taken.
  bool empty() const { return gaps_.size() == 1 && gaps_.begin()->second == size_; }

 private:
  std::size_t size_;
  std::map<std::size_t, std::size_t> gaps_;  ///< Begin and size; no two touch.
};

}  // namespace tintree::render
