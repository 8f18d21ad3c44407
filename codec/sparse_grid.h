#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace tintree::codec {

/// A value for each point of a grid, (0..side) x (0..side), kNothing at first. Memory is taken in chunks of 32 x 32
/// where a value has been set, and 8 bytes for each 2048 x 2048.
template <typename Value, Value kNothing>
class SparseGrid {
 public:
  explicit SparseGrid(std::int64_t side)
      : across_(static_cast<std::size_t>(side >> (kChunk + kTable)) + 1), tables_(across_ * across_) {}

  Value get(std::int64_t x, std::int64_t y) const {
    const auto& table = tables_[table_of(x, y)];
    if (!table) return kNothing;
    const auto& chunk = (*table)[place<kTable>(x >> kChunk, y >> kChunk)];
    return chunk ? (*chunk)[place<kChunk>(x, y)] : kNothing;
  }
  void set(std::int64_t x, std::int64_t y, Value value) {
    auto& table = tables_[table_of(x, y)];
    if (!table) table = std::make_unique<Table>();
    auto& chunk = (*table)[place<kTable>(x >> kChunk, y >> kChunk)];
    if (!chunk) {
      chunk = std::make_unique<Chunk>();
      chunk->fill(kNothing);
    }
    (*chunk)[place<kChunk>(x, y)] = value;
  }

 private:
  // The sides of a chunk, in values, and of a table, in chunks, as digits.
  static constexpr int kChunk = 5;
  static constexpr int kTable = 6;
  using Chunk = std::array<Value, 1 << (2 * kChunk)>;
  using Table = std::array<std::unique_ptr<Chunk>, 1 << (2 * kTable)>;

  std::size_t table_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(y >> (kChunk + kTable)) * across_ +
           static_cast<std::size_t>(x >> (kChunk + kTable));
  }
  /// In its chunk, or of a chunk in its table.
  template <int kDigits>
  static std::size_t place(std::int64_t x, std::int64_t y) {
    constexpr std::int64_t kMask = (1 << kDigits) - 1;
    return static_cast<std::size_t>((y & kMask) << kDigits | (x & kMask));
  }

  std::size_t across_;
  std::vector<std::unique_ptr<Table>> tables_;
};

/// The numbers of points, in the order in which they were met.
inline constexpr std::int32_t kNoPoint = -1;
using PointNumbers = SparseGrid<std::int32_t, kNoPoint>;

}  // namespace tintree::codec
