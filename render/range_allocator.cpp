#include "render/range_allocator.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace tintree::render {

std::optional<std::size_t> RangeAllocator::take(std::size_t size) {
  assert(size > 0);
  const auto gap = std::ranges::find_if(gaps_, [size](const auto& g) { return g.second >= size; });
  if (gap == gaps_.end()) return std::nullopt;
  const auto [begin, length] = *gap;
  gaps_.erase(gap);
  if (length > size) gaps_[begin + size] = length - size;
  return begin;
}

void RangeAllocator::give(std::size_t begin, std::size_t size) {
  assert(size > 0 && begin + size <= size_);
  auto [gap, added] = gaps_.emplace(begin, size);
  assert(added);
  const auto next = std::next(gap);
  if (next != gaps_.end() && begin + size == next->first) {
    gap->second += next->second;
    gaps_.erase(next);
  }
  if (gap == gaps_.begin()) return;
  const auto before = std::prev(gap);
  if (before->first + before->second != begin) return;
  before->second += gap->second;
  gaps_.erase(gap);
}

}  // namespace tintree::render
