#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cache/page_allocator.h"
#include "cache/raster_source.h"
#include "codec/error.h"

namespace tintree::cache {

/// DEM cells along the side of a block.
inline constexpr int kBlockCells = 256;
inline constexpr int kBlockSamples = kBlockCells + 1;
/// Samples between the starts of two rows; the spare ones are NaN, so that vector loads may overrun.
inline constexpr int kBlockStride = kBlockCells + 16;

/// One square of the reference surface: the samples of kBlockCells x kBlockCells cells, those on the east
/// and south side shared with the next block. Immutable.
struct HeightBlock {
  std::int64_t column0 = 0;  ///< DEM sample of the north-west corner, a multiple of kBlockCells.
  std::int64_t row0 = 0;
  /// Heights are stored relative to this, and are at most one and a half times their range then. Where they span a
  /// metre or more it is a whole number, to keep float exact on integer DEMs.
  double base_m = 0;
  bool all_valid = false;  ///< No sample of the block is missing.
  /// Row-major, kBlockStride apart, north row first; NaN for nodata and beyond the raster.
  std::vector<float, PageAllocator<float>> heights;

  const float* row(int j) const { return heights.data() + static_cast<std::ptrdiff_t>(j) * kBlockStride; }
};

/// XXH3-128 over a block's samples (docs/format.md, Digest of the samples): the low 64 bits, then the high ones.
using BlockDigest = std::array<std::uint64_t, 2>;
BlockDigest digest_of(const HeightBlock& block);

/// The DEM as a grid of blocks behind a cache of bounded size. Thread-safe.
class HeightBlocks {
 public:
  /// Keeps about `cache_bytes` of blocks in memory, those that callers hold among them; more only while they hold more.
  HeightBlocks(std::shared_ptr<const RasterSource> source, std::uint64_t cache_bytes);
  ~HeightBlocks();
  HeightBlocks(const HeightBlocks&) = delete;
  HeightBlocks& operator=(const HeightBlocks&) = delete;

  const RasterSource& source() const { return *source_; }
  std::int64_t columns() const { return columns_; }
  std::int64_t rows() const { return rows_; }
  /// Blocks over so many samples in a row or column.
  static std::int64_t blocks_along(std::int64_t samples) { return (samples - 1 + kBlockCells - 1) / kBlockCells; }
  std::int64_t blocks_x() const { return blocks_x_; }
  std::int64_t blocks_y() const { return blocks_y_; }

  /// Block (bx, by), bx eastward and by southward from the north-west; reads it if need be.
  Expected<std::shared_ptr<const HeightBlock>> get(std::int64_t bx, std::int64_t by);

  /// Bytes of the blocks in the cache.
  std::uint64_t cached_bytes() const;

  /// What every block, row by row, is known to hold: from now on get() fails with kIo for one that reads
  /// otherwise, because the file has been changed meanwhile. Call it before several threads read.
  void expect(std::vector<BlockDigest> digests) { expected_ = std::move(digests); }

  /// Reads the whole DEM once, in the order in which the file lies, and hands every block to `visit`,
  /// row of blocks by row of blocks; what fits stays in the cache. `visit` returns false to stop.
  Expected<void> stream(
      const std::function<bool(std::int64_t bx, std::int64_t by, const std::shared_ptr<const HeightBlock>&)>& visit);

 private:
  struct Cache;

  std::shared_ptr<const RasterSource> source_;
  std::int64_t columns_;
  std::int64_t rows_;
  std::int64_t blocks_x_;
  std::int64_t blocks_y_;
  std::unique_ptr<Cache> cache_;
  std::vector<BlockDigest> expected_;  // empty: nothing is known
};

}  // namespace tintree::cache
