#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace tintree::codec {

/// A value for each point of a grid, (0..side) x (0..side), kNothing at first. Memory is taken in chunks of 32 x 32
/// where a value has been set.
template <typename Value, Value kNothing>
class SparseGrid {
 public:
  explicit SparseGrid(std::int32_t side)
      : across_(static_cast<std::size_t>(side >> (2 * kShift)) + 1), tables_(across_ * across_) {}

  Value get(std::int32_t x, std::int32_t y) const {
    const auto& table = tables_[table_of(x, y)];
    if (!table) return kNothing;
    const auto& chunk = (*table)[place(x >> kShift, y >> kShift)];
    return chunk ? (*chunk)[place(x, y)] : kNothing;
  }
  void set(std::int32_t x, std::int32_t y, Value value) {
    auto& table = tables_[table_of(x, y)];
    if (!table) table = std::make_unique<Table>();
    auto& chunk = (*table)[place(x >> kShift, y >> kShift)];
    if (!chunk) {
      chunk = std::make_unique<Chunk>();
      chunk->fill(kNothing);
    }
    (*chunk)[place(x, y)] = value;
  }

 private:
  static constexpr int kShift = 5;
  static constexpr std::int32_t kSide = 1 << kShift;
  using Chunk = std::array<Value, static_cast<std::size_t>(kSide) * kSide>;
  using Table = std::array<std::unique_ptr<Chunk>, static_cast<std::size_t>(kSide) * kSide>;

  std::size_t table_of(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y >> (2 * kShift)) * across_ + static_cast<std::size_t>(x >> (2 * kShift));
  }
  /// In its chunk, or of a chunk in its table.
  static std::size_t place(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>((y & (kSide - 1)) * kSide + (x & (kSide - 1)));
  }

  std::size_t across_;
  std::vector<std::unique_ptr<Table>> tables_;
};

}  // namespace tintree::codec
