#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tintree::codec {

/// A square of kBlockCells x kBlockCells cells of a tile of method `scalar`, cut off where the tile ends. Lengths in
/// address steps.
struct GridBlock {
  std::int32_t x = 0;  ///< Of its north-west corner.
  std::int32_t y = 0;
  std::int32_t stride = 1;  ///< Side of a cell: a power of two.
  bool empty = false;       ///< No surface is there.
  std::size_t node = 0;     ///< In its tree.
};

/// Cells along a block's side.
inline constexpr std::int32_t kBlockCells = 4;

/// A tile's quadtrees of blocks. The roots have the greatest stride and cover the tile row by row; a block that is
/// split gives way to four of half its stride. Blocks come depth first: north-west, north-east, south-west, south-east.
class BlockTree {
 public:
  BlockTree() = default;
  /// `stride`: of the roots, a power of two. Memory: 4 bytes a root.
  BlockTree(std::int32_t width, std::int32_t height, std::int32_t stride)
      : width_(width),
        height_(height),
        stride_(stride),
        across_(roots_along(width, stride)),
        nodes_(static_cast<std::size_t>(across_ * roots_along(height, stride)), kLeaf) {}

  static std::int64_t roots_along(std::int32_t length, std::int32_t stride) {
    const std::int64_t side = std::int64_t{stride} * kBlockCells;
    return (length + side - 1) / side;
  }

  std::int32_t width() const { return width_; }
  std::int32_t height() const { return height_; }
  std::int32_t stride() const { return stride_; }
  std::size_t nodes() const { return nodes_.size(); }

  /// The block over the cell of 1 x 1 whose north-west corner this is.
  GridBlock at(std::int32_t x, std::int32_t y) const {
    const std::int64_t side = std::int64_t{stride_} * kBlockCells;
    const auto root = static_cast<std::size_t>(y / side * across_ + x / side);
    GridBlock block{static_cast<std::int32_t>(x / side * side), static_cast<std::int32_t>(y / side * side), stride_,
                    false, root};
    while (is_split(block.node)) {
      const std::int64_t half = std::int64_t{block.stride} * kBlockCells / 2;
      const int child = (x - block.x >= half ? 1 : 0) + (y - block.y >= half ? 2 : 0);
      block = child_of(block, child);
    }
    block.empty = nodes_[block.node] == kEmpty;
    return block;
  }

  /// Of a block whose stride is above 1.
  void split(std::size_t node) {
    nodes_[node] = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 4, kLeaf);
  }
  void set_empty(std::size_t node) { nodes_[node] = kEmpty; }
  /// An address step becomes 2^shift times as long, of which all lengths are multiples.
  void coarsen(int shift) {
    width_ >>= shift;
    height_ >>= shift;
    stride_ >>= shift;
  }

  /// Calls `visit(block)` for every block inside the tile; before that `descend(block)` says whether a block is split.
  /// It may do so itself.
  template <typename Descend, typename Visit>
  void walk(const Descend& descend, const Visit& visit) const {
    const std::int64_t side = std::int64_t{stride_} * kBlockCells;
    const std::int64_t down = roots_along(height_, stride_);
    for (std::int64_t row = 0; row < down; ++row) {
      for (std::int64_t column = 0; column < across_; ++column) {
        walk_block({static_cast<std::int32_t>(column * side), static_cast<std::int32_t>(row * side), stride_, false,
                    static_cast<std::size_t>(row * across_ + column)},
                   descend, visit);
      }
    }
  }
  template <typename Visit>
  void for_each(const Visit& visit) const {
    walk([this](const GridBlock& block) { return is_split(block.node); }, visit);
  }
  bool is_split(std::size_t node) const { return nodes_[node] != kLeaf && nodes_[node] != kEmpty; }
  bool is_empty(std::size_t node) const { return nodes_[node] == kEmpty; }

 private:
  static constexpr std::uint32_t kLeaf = 0;
  static constexpr std::uint32_t kEmpty = 0xffffffff;

  GridBlock child_of(const GridBlock& block, int child) const {
    const std::int32_t stride = block.stride / 2;
    // Beyond the tile's end nothing is asked for.
    const std::int32_t half = stride * kBlockCells;
    return {block.x + ((child & 1) != 0 ? half : 0), block.y + ((child & 2) != 0 ? half : 0), stride, false,
            nodes_[block.node] + static_cast<std::size_t>(child)};
  }

  template <typename Descend, typename Visit>
  void walk_block(GridBlock block, const Descend& descend, const Visit& visit) const {
    if (block.x >= width_ || block.y >= height_) return;
    if (!descend(block)) {
      block.empty = nodes_[block.node] == kEmpty;
      visit(block);
      return;
    }
    for (int child = 0; child < 4; ++child) walk_block(child_of(block, child), descend, visit);
  }

  std::int32_t width_ = 0;
  std::int32_t height_ = 0;
  std::int32_t stride_ = 1;
  std::int64_t across_ = 0;
  std::vector<std::uint32_t> nodes_;  // the first of four, kLeaf or kEmpty
};

}  // namespace tintree::codec
