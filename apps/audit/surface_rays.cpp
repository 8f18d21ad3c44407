#include "apps/audit/surface_rays.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "apps/audit/tile_audit.h"
#include "codec/float_rounding.h"

namespace tintree::audit {
namespace {

constexpr std::int64_t kBlock = cache::kBlockCells;
constexpr std::int64_t kSquare = 16;
constexpr std::int64_t kAcross = kBlock / kSquare;

/// The stretch of a ray over a rectangle of cells; empty when t0 >= t1.
struct Stretch {
  double t0 = 0;
  double t1 = 0;
};

Stretch clip(const GridRay& ray, Stretch s, std::size_t axis, double low, double high) {
  const double step = ray.step[axis];
  if (step == 0) return ray.origin[axis] >= low && ray.origin[axis] <= high ? s : Stretch{0, -1};
  double from = (low - ray.origin[axis]) / step;
  double to = (high - ray.origin[axis]) / step;
  if (from > to) std::swap(from, to);
  return {std::max(s.t0, from), std::min(s.t1, to)};
}

/// Visits the squares of `size` cells that a stretch passes, in its order, each with its part of the stretch,
/// until `visit` returns true.
template <typename Visit>
bool march(const GridRay& ray, const Stretch& all, std::int64_t size, const codec::CellRect& within,
           const Visit& visit) {
  const double span = static_cast<double>(size);
  const double middle = std::min(all.t0 + 1e-9 * (all.t1 - all.t0), all.t1);
  const auto begin = [&](std::size_t axis, std::int64_t first, std::int64_t last) {
    const auto k = static_cast<std::int64_t>(std::floor(ray.at(axis, middle) / span));
    return std::clamp(k, first / size, (last - 1) / size);
  };
  std::int64_t i = begin(0, within.column0, within.column1);
  std::int64_t j = begin(1, within.row0, within.row1);
  const auto leave = [&](std::size_t axis, std::int64_t k) {
    const double step = ray.step[axis];
    if (step == 0) return SurfaceRays::kMiss;
    return (static_cast<double>(step > 0 ? k + 1 : k) * span - ray.origin[axis]) / step;
  };
  double t = all.t0;
  while (true) {
    const double to_x = leave(0, i);
    const double to_y = leave(1, j);
    const double t1 = std::min({to_x, to_y, all.t1});
    if (visit(i, j, Stretch{t, std::max(t, t1)})) return true;
    if (t1 >= all.t1) return false;
    (to_x <= to_y ? i : j) += (to_x <= to_y ? ray.step[0] : ray.step[1]) > 0 ? 1 : -1;
    const bool inside =
        i * size >= within.column0 && i * size < within.column1 && j * size >= within.row0 && j * size < within.row1;
    if (!inside) return false;
    t = std::max(t, t1);
  }
}

/// Meets the plane through three corners of a cell over a stretch. `plane` gives its height at a point.
template <typename Plane>
std::optional<double> meet(const GridRay& ray, const Stretch& s, const Plane& plane) {
  const auto above = [&](double t) { return ray.at(2, t) - plane(ray.at(0, t), ray.at(1, t)); };
  const double a = above(s.t0);
  const double b = above(s.t1);
  if (std::isnan(a + b) || (a > 0 && b > 0) || (a < 0 && b < 0)) return std::nullopt;
  return a == b ? s.t0 : s.t0 + (s.t1 - s.t0) * (a / (a - b));
}

/// One cell of a block: its corners' heights.
struct Cell {
  double column;
  double row;
  double north_west;
  double north_east;
  double south_west;
  double south_east;

  double lower(double c, double r) const {
    return north_west + (r - row) * (south_west - north_west) + (c - column) * (south_east - south_west);
  }
  double upper(double c, double r) const {
    return north_west + (c - column) * (north_east - north_west) + (r - row) * (south_east - north_east);
  }

  std::optional<double> meet_ray(const GridRay& ray, const Stretch& s) const {
    // Before and behind the diagonal the ray is over one triangle each.
    const auto side = [&](double t) { return (ray.at(1, t) - row) - (ray.at(0, t) - column); };
    const double a = side(s.t0);
    const double b = side(s.t1);
    double split = s.t1;
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) split = s.t0 + (s.t1 - s.t0) * (a / (a - b));
    const auto over = [&](const Stretch& part, bool is_lower) {
      return is_lower ? meet(ray, part, [this](double c, double r) { return lower(c, r); })
                      : meet(ray, part, [this](double c, double r) { return upper(c, r); });
    };
    const bool lower_first = a > 0 || (a == 0 && b > 0);
    if (const auto hit = over({s.t0, split}, lower_first)) return hit;
    return split < s.t1 ? over({split, s.t1}, !lower_first) : std::nullopt;
  }
};

Cell cell_of(const cache::HeightBlock& block, std::int64_t column, std::int64_t row) {
  const auto i = column - block.column0;
  const float* north = block.row(static_cast<int>(row - block.row0)) + i;
  const float* south = north + cache::kBlockStride;
  const auto height = [&block](float h) { return static_cast<double>(h) + block.base_m; };
  return {static_cast<double>(column),
          static_cast<double>(row),
          height(north[0]),
          height(north[1]),
          height(south[0]),
          height(south[1])};
}

}  // namespace

/// One ray's way through the DEM.
struct SurfaceRays::Walk {
  const SurfaceRays& rays;
  const GridRay& ray;
  double found = kMiss;
  std::optional<Error> error;

  bool enters(const Range& range, const Stretch& s) const {
    const double a = ray.at(2, s.t0);
    const double b = ray.at(2, s.t1);
    return std::min(a, b) <= static_cast<double>(range.high) && std::max(a, b) >= static_cast<double>(range.low);
  }

  bool over_block(std::int64_t bx, std::int64_t by, const Stretch& s) {
    const auto number = static_cast<std::size_t>(by * rays.blocks_->blocks_x() + bx);
    if (!enters(rays.coarse_[number], s)) return false;
    const auto block = rays.blocks_->get(bx, by);
    if (!block) {
      error = block.error();
      return true;
    }
    const codec::CellRect cells{bx * kBlock, by * kBlock, (bx + 1) * kBlock, (by + 1) * kBlock};
    return march(ray, s, kSquare, cells, [&](std::int64_t i, std::int64_t j, const Stretch& part) {
      const auto square = static_cast<std::size_t>((j - by * kAcross) * kAcross + i - bx * kAcross);
      return enters(rays.fine_[number * kAcross * kAcross + square], part) && over_square(**block, i, j, part);
    });
  }

  bool over_square(const cache::HeightBlock& block, std::int64_t i, std::int64_t j, const Stretch& s) {
    const codec::CellRect cells{i * kSquare, j * kSquare, (i + 1) * kSquare, (j + 1) * kSquare};
    return march(ray, s, 1, cells, [&](std::int64_t column, std::int64_t row, const Stretch& part) {
      const auto hit = cell_of(block, column, row).meet_ray(ray, part);
      if (hit) found = *hit;
      return hit.has_value();
    });
  }
};

SurfaceRays::SurfaceRays(std::shared_ptr<const cache::RasterSource> source, std::uint64_t cache_bytes)
    : blocks_(std::make_unique<cache::HeightBlocks>(std::move(source), cache_bytes)) {
  const auto count = static_cast<std::size_t>(blocks_->blocks_x() * blocks_->blocks_y());
  coarse_.resize(count);
  fine_.resize(count * kAcross * kAcross);
}

Expected<SurfaceRays> SurfaceRays::scan(std::shared_ptr<const cache::RasterSource> source, std::uint64_t cache_bytes,
                                        const std::function<bool(std::int64_t)>& advance) {
  SurfaceRays rays(std::move(source), cache_bytes);
  bool stopped = false;
  const auto streamed = rays.blocks_->stream([&](std::int64_t bx, std::int64_t by, const auto& block) {
    rays.take(bx, by, *block);
    stopped = !advance(kBlock * kBlock);
    return !stopped;
  });
  if (!streamed) return tl::unexpected(streamed.error());
  if (stopped) return tl::unexpected(stopped_error());
  return rays;
}

void SurfaceRays::take(std::int64_t bx, std::int64_t by, const cache::HeightBlock& block) {
  const auto number = static_cast<std::size_t>(by * blocks_->blocks_x() + bx);
  Range& whole = coarse_[number];
  for (int square = 0; square < kAcross * kAcross; ++square) {
    const auto i0 = static_cast<int>(square % kAcross * kSquare);
    const auto j0 = static_cast<int>(square / kAcross * kSquare);
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    for (int j = j0; j <= j0 + kSquare; ++j) {
      const float* line = block.row(j);
      for (int i = i0; i <= i0 + kSquare; ++i) {
        low = line[i] < low ? line[i] : low;
        high = line[i] > high ? line[i] : high;
      }
    }
    if (low > high) continue;
    const Range range{codec::round_down(static_cast<double>(low) + block.base_m),
                      codec::round_up(static_cast<double>(high) + block.base_m)};
    fine_[number * kAcross * kAcross + static_cast<std::size_t>(square)] = range;
    whole = {std::min(whole.low, range.low), std::max(whole.high, range.high)};
  }
  whole_ = {std::min(whole_.low, whole.low), std::max(whole_.high, whole.high)};
}

Expected<double> SurfaceRays::cast(const GridRay& ray) const {
  const codec::CellRect cells{0, 0, blocks_->columns() - 1, blocks_->rows() - 1};
  Stretch s{0, kMiss};
  s = clip(ray, s, 0, 0, static_cast<double>(cells.column1));
  s = clip(ray, s, 1, 0, static_cast<double>(cells.row1));
  s = clip(ray, s, 2, static_cast<double>(whole_.low) - 1, static_cast<double>(whole_.high) + 1);
  if (!(s.t0 <= s.t1)) return kMiss;
  Walk walk{*this, ray, kMiss, {}};
  march(ray, s, kBlock, cells,
        [&](std::int64_t bx, std::int64_t by, const Stretch& part) { return walk.over_block(bx, by, part); });
  if (walk.error) return tl::unexpected(*walk.error);
  return walk.found;
}

Expected<double> SurfaceRays::height(double column, double row) const {
  const std::int64_t last_column = blocks_->columns() - 2;
  const std::int64_t last_row = blocks_->rows() - 2;
  if (!(column >= 0 && row >= 0 && column <= static_cast<double>(last_column + 1) &&
        row <= static_cast<double>(last_row + 1))) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const std::int64_t c = std::min(static_cast<std::int64_t>(column), last_column);
  const std::int64_t r = std::min(static_cast<std::int64_t>(row), last_row);
  const auto block = blocks_->get(c / kBlock, r / kBlock);
  if (!block) return tl::unexpected(block.error());
  const Cell cell = cell_of(**block, c, r);
  return row - static_cast<double>(r) > column - static_cast<double>(c) ? cell.lower(column, row)
                                                                        : cell.upper(column, row);
}

}  // namespace tintree::audit
