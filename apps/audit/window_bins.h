#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "apps/audit/tile_surface.h"

namespace tintree::audit {

/// Numbers filed under buckets, in one array.
class Buckets {
 public:
  /// One bucket with the numbers from 0 to count - 1.
  explicit Buckets(std::size_t count) : begin_{0, count}, numbers_(count) {
    std::iota(numbers_.begin(), numbers_.end(), 0U);
  }
  /// `each` calls its argument with (bucket, number) for every entry; it is run twice.
  template <typename Each>
  Buckets(std::size_t count, const Each& each) : begin_(count + 2, 0) {
    each([this](std::size_t bucket, std::uint32_t) { ++begin_[bucket + 2]; });
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    numbers_.resize(begin_.back());
    each([this](std::size_t bucket, std::uint32_t number) { numbers_[begin_[bucket + 1]++] = number; });
  }

  std::span<const std::uint32_t> of(std::size_t bucket) const {
    return {numbers_.data() + begin_[bucket], begin_[bucket + 1] - begin_[bucket]};
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> numbers_;
};

/// Divides a tile into windows and files the mesh's parts under every window that their bounding box
/// touches, so that a tile of any size is measured window by window.
class WindowBins {
 public:
  explicit WindowBins(const TileSurface& surface);

  /// Windows in row-major order.
  std::size_t count() const { return static_cast<std::size_t>(grid_.nx * grid_.ny); }
  /// Cells of a window, tile-local.
  codec::CellRect cells(std::size_t window) const;

  std::span<const std::uint32_t> triangles(std::size_t window) const { return triangles_.of(window); }
  std::span<const std::uint32_t> edges(std::size_t window) const { return edges_.of(window); }
  std::span<const std::uint32_t> corners(std::size_t window) const { return corners_.of(window); }

 private:
  struct Grid {
    explicit Grid(const TileSurface& surface);
    /// Calls visit(window) for every window that the box, in lattice units, touches.
    template <typename Visit>
    void touched(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, const Visit& visit) const;
    /// Files `count` parts of the mesh; corners_of(number) lists a part's corners.
    template <typename Corners>
    Buckets file(const TileSurface& surface, std::size_t count, const Corners& corners_of) const;

    std::int64_t width;  // cells
    std::int64_t height;
    std::int64_t nx;
    std::int64_t ny;
    int shift;  // two to this power lattice units are a window
  };

  Grid grid_;
  Buckets triangles_;
  Buckets edges_;
  Buckets corners_;
};

}  // namespace tintree::audit
