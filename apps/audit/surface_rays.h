#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "cache/height_blocks.h"

namespace tintree::audit {

/// A ray in the grid: column, row and height in metres at parameter t are linear in t.
struct GridRay {
  std::array<double, 3> origin{};
  std::array<double, 3> step{};

  double at(std::size_t axis, double t) const { return origin[axis] + t * step[axis]; }
};

/// Where rays meet the reference surface, exactly: triangle by triangle, from above or from below. Squares of 16
/// and 256 cells whose height range a ray does not enter are stepped over. Memory: 1/32 byte a sample, and the
/// blocks' cache. Thread-safe once scanned.
class SurfaceRays {
 public:
  static constexpr double kMiss = std::numeric_limits<double>::infinity();

  /// Reads the DEM once. `advance` is told of cells read and returns false to stop (kStopped).
  static Expected<SurfaceRays> scan(std::shared_ptr<const cache::RasterSource> source, std::uint64_t cache_bytes,
                                    const std::function<bool(std::int64_t)>& advance);

  /// The least t > 0 at which the ray is on the surface, or kMiss.
  Expected<double> cast(const GridRay& ray) const;
  /// The surface at a point of the grid; NaN where it has none.
  Expected<double> height(double column, double row) const;
  /// Greatest height of all samples.
  double highest_m() const { return static_cast<double>(whole_.high); }

 private:
  struct Range {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();
  };
  struct Walk;

  explicit SurfaceRays(std::shared_ptr<const cache::RasterSource> source, std::uint64_t cache_bytes);
  void take(std::int64_t bx, std::int64_t by, const cache::HeightBlock& block);

  std::unique_ptr<cache::HeightBlocks> blocks_;
  std::vector<Range> coarse_;  ///< Of blocks, row-major.
  std::vector<Range> fine_;    ///< Of squares of 16 cells, 256 to a block.
  Range whole_;                ///< Of the DEM.
};

}  // namespace tintree::audit
