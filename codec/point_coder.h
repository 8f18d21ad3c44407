#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/nested_points.h"
#include "codec/quick_bit_model.h"
#include "codec/range_coder.h"
#include "codec/split_heights.h"
#include "codec/split_hierarchy.h"

namespace tintree::codec {

/// Codes NestedPoints level by level: of each place where triangles can be split, as both of its parents are points,
/// whether they are; where they are, whether there is surface and how high. One program for both ways: `Coder` is
/// RangeEncoder or RangeDecoder, and what is to be written comes from `source`, null when reading.
template <typename Coder>
class PointCoder {
 public:
  PointCoder(NestedPoints& points, const NestedPoints* source) : points_(points), source_(source) {}

  /// Adds the points of the next level. False when reading finds more than `most` points or a height out of range.
  bool code(Coder& coder, std::size_t most) {
    coder_ = &coder;
    most_ = most;
    if (level_ == 0) add_base();
    // Grows while it is gone through; what stays is asked again for the next level.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < places_.size() && sound_; ++i) {
      const Place place = places_[i];
      if (!split(place)) places_[kept++] = place;
    }
    places_.resize(kept);
    ++level_;
    return sound_;
  }

 private:
  static constexpr std::int32_t kNone = NestedPoints::kNone;

  /// Where triangles can be split: the ends of their longest side and their right angles, the second one none where
  /// the tile ends.
  struct Place {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t end_a = kNone;
    std::int32_t end_b = kNone;
    std::int32_t apex = kNone;
    std::int32_t other_apex = kNone;
  };

  const NestedPoint* wanted(std::int32_t x, std::int32_t y) const {
    const std::int32_t i = source_ != nullptr ? source_->find(x, y) : kNone;
    return i != kNone && source_->point(i).level <= level_ ? &source_->point(i) : nullptr;
  }

  void add_base() {
    for (std::int32_t i = 0; i < NestedPoints::kBasePoints && sound_; ++i) {
      const auto [x, y] = points_.base_place(i);
      add({x, y, kNone, kNone, kNone, kNone}, wanted(x, y));
    }
    if (sound_) add_places(NestedPoints::kBasePoints - 1);
  }

  bool fresh(std::int32_t i) const { return points_.point(i).level == level_; }
  bool gap(std::int32_t i) const { return i != kNone && points_.point(i).gap; }

  bool split(const Place& p) {
    const std::int32_t other = p.other_apex != kNone ? p.other_apex : p.apex;
    const std::int32_t unit = (p.x | p.y) & -(p.x | p.y);
    const auto shape =
        2 * static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(unit))) + ((p.x & p.y & unit) != 0 ? 1U : 0U);
    const std::size_t news = (fresh(p.apex) ? 1U : 0U) + (fresh(other) ? 1U : 0U);
    const bool holes = gap(p.end_a) || gap(p.end_b) || gap(p.apex) || gap(other);
    const int rough = std::max(height(p.apex).digits, height(other).digits) + level_ - kSmooth;
    const auto row = static_cast<std::size_t>(std::clamp(rough, 0, 3));
    const NestedPoint* wish = wanted(p.x, p.y);
    QuickBitModel& model = split_[((shape * 3 + news) * 4 + row) * 2 + (holes ? 1 : 0)];
    if (!coder_->bit(model, wish != nullptr)) return false;
    add_places(add(p, wish));
    return true;
  }

  SplitHeight height(std::int32_t i) const {
    return i == kNone ? SplitHeight{} : heights_[static_cast<std::size_t>(i)];
  }

  std::int32_t add(const Place& p, const NestedPoint* wish) {
    NestedPoint point{p.x, p.y, 0, static_cast<std::uint8_t>(level_), false, p.end_a, p.end_b};
    point.gap = coder_->bit(gap_[(gap(p.end_a) ? 1U : 0U) + (gap(p.end_b) ? 1U : 0U)], wish != nullptr && wish->gap);
    SplitHeight made;
    if (!point.gap) {
      made = models_.code(*coder_, {height(p.end_a), height(p.end_b), height(p.apex), height(p.other_apex)},
                          wish != nullptr ? wish->z : 0);
      sound_ = sound_ && made.z >= 0 && made.z <= kMaxHeightAddress;
      point.z = sound_ ? static_cast<std::int32_t>(made.z) : 0;
    }
    heights_.push_back(made);
    sound_ = sound_ && points_.points().size() < most_;
    return points_.add(point);
  }

  /// The places whose second parent a new point is.
  void add_places(std::int32_t number) {
    const SplitPoint from{points_.point(number).x, points_.point(number).y};
    if (((from.x | from.y) & 1) != 0 && (from.x & from.y & 1) == 0) return;
    const auto inside = [side = points_.side()](const SplitPoint& p) {
      return p.x >= 0 && p.y >= 0 && p.x <= side && p.y <= side;
    };
    const auto find = [&](std::int64_t x, std::int64_t y) {
      return points_.find(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
    };
    for (const SplitPoint& p : split_children(from)) {
      if (!inside(p)) continue;
      const SplitPoint across{2 * p.x - from.x, 2 * p.y - from.y};
      const bool border = !inside(across);
      const std::int32_t other = border ? kNone : find(across.x, across.y);
      if (other == kNone && !border) continue;
      const SplitPoint turn{from.y - p.y, p.x - from.x};
      places_.push_back({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y),
                         find(p.x + turn.x, p.y + turn.y), find(p.x - turn.x, p.y - turn.y), number, other});
    }
  }

  static constexpr std::size_t kShapes = 2 * (NestedPoints::kMostSideBits + 2);
  /// Points of level 0 that are off by fewer digits, of level 1 by one less and so on, count for smooth ground.
  static constexpr int kSmooth = 8;

  NestedPoints& points_;
  const NestedPoints* source_;
  Coder* coder_ = nullptr;
  int level_ = 0;
  std::size_t most_ = 0;
  bool sound_ = true;
  std::vector<Place> places_;
  std::vector<SplitHeight> heights_;  // of the points; of gaps none
  std::array<QuickBitModel, kShapes * 24> split_;
  std::array<QuickBitModel, 3> gap_;
  SplitHeights models_;
};

}  // namespace tintree::codec
