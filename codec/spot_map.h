#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/split_hierarchy.h"

namespace tintree::codec {

/// Values at points of a tile, x and y from 0 to 2^31: a hash table in one piece of memory, linear probing. Not
/// thread-safe.
template <typename Value>
class SpotMap {
 public:
  SpotMap() : slots_(kFewest) {}

  /// Null where none was put; valid until the next insert().
  const Value* find(const SplitPoint& spot) const {
    const Slot& slot = slots_[place(key(spot))];
    return slot.key == kEmpty ? nullptr : &slot.value;
  }
  /// False, and nothing changes, where there is one already.
  bool insert(const SplitPoint& spot, Value value) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[place(key(spot))];
    if (slot.key != kEmpty) return false;
    slot = {key(spot), std::move(value)};
    ++count_;
    return true;
  }

 private:
  static constexpr std::size_t kFewest = 1024;
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  struct Slot {
    std::uint64_t key = kEmpty;
    Value value{};
  };

  static std::uint64_t key(const SplitPoint& p) {
    return static_cast<std::uint64_t>(p.y) << 32 | static_cast<std::uint64_t>(p.x);
  }
  /// The slot that holds the key, or the one that it would be put into.
  std::size_t place(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = (key * 0x9e3779b97f4a7c15U) >> (64 - std::countr_zero(slots_.size()));
    while (slots_[at].key != key && slots_[at].key != kEmpty) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (Slot& slot : old) {
      if (slot.key != kEmpty) slots_[place(slot.key)] = std::move(slot);
    }
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
};

}  // namespace tintree::codec
