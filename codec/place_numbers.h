#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tintree::codec {

/// Numbers places in the order in which they come. Memory: 24 to 48 bytes a place, however far apart they lie.
class PlaceNumbers {
 public:
  /// A place's number, and whether it is a new one.
  std::pair<std::uint32_t, bool> add(std::int32_t x, std::int32_t y) {
    if (2 * count_ >= slots_.size()) grow();
    Slot& slot = find(slots_, key_of(x, y));
    if (slot.number != kFree) return {slot.number, false};
    slot = {key_of(x, y), count_};
    return {count_++, true};
  }

 private:
  static constexpr std::uint32_t kFree = 0xffffffff;

  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = kFree;
  };

  static std::uint64_t key_of(std::int32_t x, std::int32_t y) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32 | static_cast<std::uint32_t>(x);
  }
  /// The key's slot, or the free one that is to be it.
  static Slot& find(std::vector<Slot>& slots, std::uint64_t key) {
    const std::size_t mask = slots.size() - 1;
    std::size_t at = static_cast<std::size_t>((key ^ key >> 29) * 0x9e3779b97f4a7c15U >> 24) & mask;
    while (slots[at].number != kFree && slots[at].key != key) at = (at + 1) & mask;
    return slots[at];
  }
  void grow() {
    std::vector<Slot> larger(slots_.empty() ? 1024 : 2 * slots_.size());
    for (const Slot& slot : slots_) {
      if (slot.number != kFree) find(larger, slot.key) = slot;
    }
    slots_ = std::move(larger);
  }

  std::vector<Slot> slots_;  // a power of two, at most half of them taken
  std::uint32_t count_ = 0;
};

}  // namespace tintree::codec
