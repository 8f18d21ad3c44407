#pragma once

#include <algorithm>
#include <cstddef>

namespace tintree::codec {

/// Block compression cuts a picture into blocks of 4 x 4 texels, row by row from the north-west. Where the picture
/// ends inside a block, the block goes on with the last column and row.
inline constexpr int kBlockSide = 4;

inline int blocks_across(int size) { return (size + kBlockSide - 1) / kBlockSide; }
inline std::size_t blocks_in(int size) {
  return static_cast<std::size_t>(blocks_across(size)) * static_cast<std::size_t>(blocks_across(size));
}

/// Calls visit(block, i, x, y) for the 16 texels i of every block; x and y lie inside the picture. After the last
/// texel of a block it calls done(block).
template <typename Visit, typename Done>
void for_each_block(int size, const Visit& visit, const Done& done) {
  const int across = blocks_across(size);
  for (int by = 0; by < across; ++by) {
    for (int bx = 0; bx < across; ++bx) {
      const auto block = static_cast<std::size_t>(by) * static_cast<std::size_t>(across) + static_cast<std::size_t>(bx);
      for (int i = 0; i < kBlockSide * kBlockSide; ++i) {
        visit(block, static_cast<std::size_t>(i), std::min(kBlockSide * bx + i % kBlockSide, size - 1),
              std::min(kBlockSide * by + i / kBlockSide, size - 1));
      }
      done(block);
    }
  }
}

/// Calls visit(i, x, y) for those of a block's 16 texels i that lie inside the picture.
template <typename Visit>
void for_each_texel(int size, std::size_t block, const Visit& visit) {
  const auto across = static_cast<std::size_t>(blocks_across(size));
  const int x0 = static_cast<int>(block % across) * kBlockSide;
  const int y0 = static_cast<int>(block / across) * kBlockSide;
  for (int y = y0; y < std::min(y0 + kBlockSide, size); ++y) {
    for (int x = x0; x < std::min(x0 + kBlockSide, size); ++x) {
      visit(static_cast<std::size_t>((y - y0) * kBlockSide + x - x0), x, y);
    }
  }
}

}  // namespace tintree::codec
