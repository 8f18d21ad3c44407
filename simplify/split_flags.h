#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

namespace tintree::simplify {

/// A bit for each point of a tile's grid, (0..cells) x (0..cells): "the right triangles that meet
/// here have to be split". Only chunks with a bit set take memory, so a level whose surface is mostly flat
/// at its bound costs little however large its tiles. After number(), each set bit has a rank.
class SplitFlags {
 public:
  explicit SplitFlags(std::int64_t cells)
      : across_((cells >> kShift) + 1), chunks_(static_cast<std::size_t>(across_ * across_)) {}

  bool get(std::int64_t x, std::int64_t y) const {
    const Chunk* chunk = chunks_[chunk_of(x, y)].get();
    return chunk != nullptr && (chunk->bits[word_of(x, y)] >> (x & 63) & 1) != 0;
  }

  /// Sets the bit; true when it was clear.
  bool set(std::int64_t x, std::int64_t y) {
    auto& chunk = chunks_[chunk_of(x, y)];
    if (!chunk) chunk = std::make_unique<Chunk>();
    std::uint64_t& word = chunk->bits[word_of(x, y)];
    const std::uint64_t bit = std::uint64_t{1} << (x & 63);
    const bool fresh = (word & bit) == 0;
    word |= bit;
    return fresh;
  }

  void clear(std::int64_t x, std::int64_t y) {
    Chunk* chunk = chunks_[chunk_of(x, y)].get();
    if (chunk != nullptr) chunk->bits[word_of(x, y)] &= ~(std::uint64_t{1} << (x & 63));
  }

  /// Calls `visit(x, y)` for every set bit.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
      if (!chunks_[c]) continue;
      const std::int64_t x0 = static_cast<std::int64_t>(c) % across_ * kSide;
      const std::int64_t y0 = static_cast<std::int64_t>(c) / across_ * kSide;
      // A row of a chunk is one word.
      for (std::size_t row = 0; row < kWords; ++row) {
        for (std::uint64_t word = chunks_[c]->bits[row]; word != 0; word &= word - 1)
          visit(x0 + std::countr_zero(word), y0 + static_cast<std::int64_t>(row));
      }
    }
  }

  /// Ranks all set bits; returns their number.
  std::int32_t number() {
    std::int32_t count = 0;
    for (const auto& chunk : chunks_) {
      if (!chunk) continue;
      for (std::size_t i = 0; i < kWords; ++i) {
        chunk->before[i] = count;
        count += std::popcount(chunk->bits[i]);
      }
    }
    return count;
  }

  /// Rank of a set bit, 0 to number() - 1.
  std::int32_t rank(std::int64_t x, std::int64_t y) const {
    const Chunk& chunk = *chunks_[chunk_of(x, y)];
    const std::size_t word = word_of(x, y);
    const std::uint64_t below = chunk.bits[word] & ((std::uint64_t{1} << (x & 63)) - 1);
    return chunk.before[word] + std::popcount(below);
  }

 private:
  static constexpr int kShift = 6;
  static constexpr std::int64_t kSide = std::int64_t{1} << kShift;
  static constexpr std::size_t kWords = kSide * kSide / 64;

  struct Chunk {
    std::array<std::uint64_t, kWords> bits{};
    std::array<std::int32_t, kWords> before{};
  };

  std::size_t chunk_of(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((y >> kShift) * across_ + (x >> kShift));
  }
  static std::size_t word_of(std::int64_t x, std::int64_t y) {
    return static_cast<std::size_t>(((y & (kSide - 1)) * kSide + (x & (kSide - 1))) / 64);
  }

  std::int64_t across_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
};

}  // namespace tintree::simplify
