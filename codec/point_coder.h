#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/range_coder.h"
#include "codec/nested_points.h"

namespace tintree::codec {

/// Codes the points of NestedPoints level by level: for each triangle of the level before, and then of those that it
/// is split into, whether it is split; where it is, whether there is surface and how far it lies above the middle
/// between the ends of the longest side. One program for both ways: `Coder` is RangeEncoder or RangeDecoder, and what
/// is to be written comes from `source`, null when reading.
template <typename Coder>
class PointCoder {
 public:
  PointCoder(NestedPoints& points, const NestedPoints* source)
      : points_(points), source_(source), asked_(points.side()) {}

  /// Adds the points of the next level. False when reading finds more than `most` points or a height out of range.
  bool code(Coder& coder, std::size_t most) {
    coder_ = &coder;
    most_ = most;
    for (std::int32_t i = 0; level_ == 0 && sound_ && i < NestedPoints::kBasePoints; ++i) add_base(i);
    if (sound_) {
      points_.walk([this](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t x,
                          std::int32_t y) { return split(a, b, c, x, y); },
                   [](std::int32_t, std::int32_t, std::int32_t) {});
    }
    ++level_;
    return sound_;
  }

 private:
  static constexpr std::int32_t kNone = NestedPoints::kNone;

  const NestedPoint* wanted(std::int32_t x, std::int32_t y) const {
    const std::int32_t i = source_ != nullptr ? source_->find(x, y) : kNone;
    return i != kNone && source_->point(i).level <= level_ ? &source_->point(i) : nullptr;
  }

  void add_base(std::int32_t number) {
    const auto [x, y] = points_.base_place(number);
    add({x, y, 0, 0, false, kNone, kNone}, wanted(x, y), last_z_, 0);
  }

  std::int32_t split(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t x, std::int32_t y) {
    const std::int32_t known = points_.find(x, y);
    if (known != kNone || !sound_) return known;
    if (asked_.get(x, y) == level_ + 1) return kNone;
    const NestedPoint& from = points_.point(a);
    const NestedPoint& to = points_.point(b);
    const NestedPoint& apex = points_.point(c);
    const int width = std::abs(from.x - to.x);
    const int height = std::abs(from.y - to.y);
    const auto size = static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(std::max(width, height))));
    const std::size_t shape = 2 * size + (width == height ? 1 : 0);
    const std::size_t fresh = (apex.level == level_ ? 1U : 0U) + (from.level == level_ || to.level == level_ ? 1U : 0U);
    const std::size_t gap = from.gap || to.gap || apex.gap ? 1 : 0;
    const NestedPoint* wish = wanted(x, y);
    if (!coder_->bit(split_[level_][(shape * 3 + fresh) * 2 + gap], wish != nullptr)) {
      asked_.set(x, y, static_cast<std::uint8_t>(level_ + 1));
      return kNone;
    }
    const std::int32_t middle = from.gap ? to.gap ? last_z_ : to.z : to.gap ? from.z : (from.z + to.z) >> 1;
    const std::uint8_t rough = std::max({rough_of(a), rough_of(b), rough_of(c)});
    return add({x, y, 0, static_cast<std::uint8_t>(level_), false, a, b}, wish, middle, rough);
  }

  std::uint8_t rough_of(std::int32_t i) const { return rough_[static_cast<std::size_t>(i)]; }

  std::int32_t add(NestedPoint point, const NestedPoint* wish, std::int32_t expected_z, std::uint8_t rough) {
    const auto gaps = [&](std::int32_t i) { return i != kNone && points_.point(i).gap ? std::size_t{1} : 0; };
    point.gap = coder_->bit(gap_[gaps(point.end_a) + gaps(point.end_b)], wish != nullptr && wish->gap);
    std::uint8_t digits = 0;
    if (!point.gap) {
      NumberModel& model = height_[std::min<std::size_t>(rough, kRoughness - 1)];
      const std::int64_t residual = model.code(*coder_, wish != nullptr ? std::int64_t{wish->z} - expected_z : 0);
      const std::int64_t z = expected_z + residual;
      sound_ = sound_ && z >= 0 && z <= kMaxHeightAddress;
      point.z = last_z_ = sound_ ? static_cast<std::int32_t>(z) : 0;
      digits = static_cast<std::uint8_t>(std::bit_width(static_cast<std::uint64_t>(std::abs(residual))));
    }
    rough_.push_back(digits);
    sound_ = sound_ && points_.points().size() < most_;
    return points_.add(point);
  }

  static constexpr std::size_t kRoughness = 16;
  static constexpr std::size_t kShapes = 2 * (NestedPoints::kMostSideBits + 2);
  static constexpr std::size_t kMostLevels = 9;

  NestedPoints& points_;
  const NestedPoints* source_;
  Coder* coder_ = nullptr;
  int level_ = 0;
  std::size_t most_ = 0;
  bool sound_ = true;
  std::int32_t last_z_ = 0;
  std::vector<std::uint8_t> rough_;    // digits of each point's residual
  SparseGrid<std::uint8_t, 0> asked_;  // the level, from 1, that was last asked in vain
  std::array<std::array<BitModel, kShapes * 6>, kMostLevels> split_;
  std::array<BitModel, 3> gap_;
  std::array<NumberModel, kRoughness> height_;
};

}  // namespace tintree::codec
