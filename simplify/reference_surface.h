#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/height_blocks.h"
#include "cache/paged_records.h"
#include "codec/error.h"
#include "codec/grid_frame.h"
#include "codec/stop_flag.h"
#include "simplify/block_patches.h"

namespace tintree::simplify {

/// The DEM's surface S (docs/accuracy.md): samples joined into a regular triangulation whose diagonals run
/// from north-west to south-east. Holds the residual pyramid of the whole DEM; samples are paged.
/// Immutable after scan() and safe to share between threads.
class ReferenceSurface {
 public:
  /// Where the residual pyramid lies: in memory as long as it takes no more than this, else in a temporary file.
  struct Pyramid {
    std::uint64_t resident_bytes = std::uint64_t{1} << 40;
    std::string folder = ".";
  };
  /// What the whole pyramid of a DEM of so many samples takes: about a tenth of a byte for each.
  static std::uint64_t pyramid_bytes(std::int64_t columns, std::int64_t rows);

  /// Reads the DEM once. `progress(done, total)` counts blocks and returns false to stop (kStopped). From then on
  /// `blocks` refuses to read anything else from the file than what was scanned.
  static Expected<std::unique_ptr<ReferenceSurface>> scan(
      std::shared_ptr<cache::HeightBlocks> blocks,
      const std::function<bool(std::uint64_t done, std::uint64_t total)>& progress, const Pyramid& pyramid);
  static Expected<std::unique_ptr<ReferenceSurface>> scan(
      std::shared_ptr<cache::HeightBlocks> blocks,
      const std::function<bool(std::uint64_t done, std::uint64_t total)>& progress) {
    return scan(std::move(blocks), progress, Pyramid{});
  }

  /// Looks at the blocks under these rectangles of cells only, over all threads of the current oneTBB arena: enough
  /// to make tiles whose cells, and one more on every side, lie in them. Of the other blocks it knows nothing, and
  /// valid_samples(), has_surface() and digest() say nothing of the DEM.
  static Expected<std::unique_ptr<ReferenceSurface>> scan_windows(std::shared_ptr<cache::HeightBlocks> blocks,
                                                                  const std::vector<codec::CellRect>& windows,
                                                                  const StopFlag* stop);

  cache::HeightBlocks& blocks() const { return *blocks_; }
  const BlockPatches& patches(std::int64_t bx, std::int64_t by) const {
    std::int64_t place = by * blocks_->blocks_x() + bx;
    if (!places_.empty()) place = places_[static_cast<std::size_t>(place)];
    return *reinterpret_cast<const BlockPatches*>(patches_->at(place));
  }
  /// Samples that exist.
  std::uint64_t valid_samples() const { return valid_samples_; }
  /// Whether any triangle exists: three samples of one cell with heights.
  bool has_surface() const { return has_surface_; }
  /// XXH3-128 over all samples, in hexadecimal.
  const std::string& digest() const { return digest_; }
  /// Lowest and highest sample of a rectangle of cells, widened to whole blocks; {+inf, -inf} when none.
  std::array<double, 2> height_range_m(const codec::CellRect& cells) const;
  /// What the rounding of heights in a rectangle of cells, widened to whole blocks, goes by; zeros when there are none.
  struct HeightScale {
    double relief_m = 0;    ///< Largest difference within a block.
    double farthest_m = 0;  ///< From height 0.
  };
  HeightScale height_scale(const codec::CellRect& cells) const;

 private:
  template <typename Visit>
  void for_each_range(const codec::CellRect& cells, const Visit& visit) const;

  std::shared_ptr<cache::HeightBlocks> blocks_;
  std::optional<cache::PagedRecords> patches_;
  std::vector<std::int32_t> places_;  // of the blocks' records; empty: in order
  std::vector<std::array<double, 2>> ranges_;
  std::uint64_t valid_samples_ = 0;
  bool has_surface_ = false;
  std::string digest_;
};

/// One thread's access to the samples: keeps the blocks it uses pinned, a bounded number of them. The first
/// failure to read is kept in error() and everything after it reads as missing, so that inner loops
/// need not look. Not thread-safe.
class SurfaceView {
 public:
  /// `stop` may be null and must outlive the view.
  explicit SurfaceView(const ReferenceSurface& surface, const StopFlag* stop = nullptr)
      : surface_(&surface), stop_(stop) {}

  const ReferenceSurface& surface() const { return *surface_; }
  /// The block of cell (column, row); valid until the next call. Cells outside the DEM read as missing.
  const cache::HeightBlock& block_of(std::int64_t column, std::int64_t row) {
    const std::int64_t bx = column >> 8;
    const std::int64_t by = row >> 8;
    return bx == last_bx_ && by == last_by_ ? *last_ : fetch(bx, by);
  }
  /// Height of a sample in metres, NaN when it is missing or outside the DEM.
  double sample(std::int64_t column, std::int64_t row);
  /// Heights of a window as the DEM has them, in double (RasterSource::read); block heights are rounded to float.
  void read_exact(const codec::CellRect& window, std::vector<double>& heights_m);
  const std::optional<Error>& error() const { return error_; }
  /// True when there is no point in going on: a read has failed or a stop was asked for; error() says which.
  /// Long loops ask this every few milliseconds.
  bool interrupted() {
    if (!error_ && is_set(stop_)) error_ = Error{ErrorCode::kStopped, "stopped", {}};
    return error_.has_value();
  }

 private:
  const cache::HeightBlock& fetch(std::int64_t bx, std::int64_t by);

  static constexpr std::size_t kPinnedBlocks = 64;

  const ReferenceSurface* surface_;
  const StopFlag* stop_;
  struct Pin {
    std::int64_t key = -1;
    std::shared_ptr<const cache::HeightBlock> block;
  };
  std::array<Pin, kPinnedBlocks> pins_;
  const cache::HeightBlock* last_ = nullptr;
  std::int64_t last_bx_ = -1;
  std::int64_t last_by_ = -1;
  std::optional<Error> error_;
};

}  // namespace tintree::simplify
