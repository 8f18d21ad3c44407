#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cache/height_blocks.h"

namespace tintree::cache {

/// The digest of a DEM's heights that a tree keeps (docs/format.md, Digest of the samples): XXH3-128 over the
/// XXH3-128 of all blocks. Equal heights give equal digests, whatever file holds them. Memory: 16 bytes a block.
class SamplesDigest {
 public:
  explicit SamplesDigest(const HeightBlocks& blocks);

  /// Takes block (bx, by) in. Any order; different blocks may be added by several threads at once.
  void add(std::int64_t bx, std::int64_t by, const HeightBlock& block);
  /// 32 hexadecimal digits, once every block has been added.
  std::string text() const;
  /// Gives away what was added, for HeightBlocks::expect.
  std::vector<BlockDigest> take() { return std::move(digests_); }

 private:
  std::int64_t blocks_x_;
  std::vector<BlockDigest> digests_;
};

}  // namespace tintree::cache
