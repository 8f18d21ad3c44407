#include "render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tintree::render {
namespace {

constexpr std::size_t kLines = cache::Occluder::kLines;
constexpr std::size_t kStrips = cache::Occluder::kStrips;
/// A corner of the picture must look ahead by this much of its ray's length, or the directions spread too far.
constexpr double kLeastAhead = 0.2;
/// Nearer than this, metres, nothing is projected.
constexpr double kNear = 1e-3;

float round_down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

}  // namespace

Horizon::Horizon(const Camera& camera, double off_px)
    : eye_x_(camera.eye.x), eye_y_(camera.eye.y), eye_z_(camera.eye.z) {
  v_.fill(-std::numeric_limits<float>::infinity());
  const CameraAxes axes = camera.axes();
  // The picture's right is level, so this is the view's own azimuth.
  ahead_x_ = -axes.right.y;
  ahead_y_ = axes.right.x;
  double u_high = -std::numeric_limits<double>::infinity();
  u_low_ = -u_high;
  usable_ = true;
  double least_ahead = 1;
  for (const double x : {0.0, static_cast<double>(camera.width_px)}) {
    for (const double y : {0.0, static_cast<double>(camera.height_px)}) {
      const glm::dvec3 ray = camera.ray(x, y);
      const double ahead = ray.x * ahead_x_ + ray.y * ahead_y_;
      const double right = ray.x * axes.right.x + ray.y * axes.right.y;
      least_ahead = std::min(least_ahead, ahead / std::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z));
      u_low_ = std::min(u_low_, right / ahead);
      u_high = std::max(u_high, right / ahead);
    }
  }
  usable_ = least_ahead >= kLeastAhead;
  if (!usable_) return;
  bins_per_u_ = static_cast<double>(kBins) / (u_high - u_low_);
  // Both are off; in the picture, distances are at most 1 / least_ahead of what they are ahead.
  margin_ = (kMarginPx + 2 * off_px / least_ahead) / camera.focal_px();
}

void Horizon::place_eye(bool above_ground) {
  placed_ = true;
  usable_ = usable_ && above_ground;
}

Horizon::Plan Horizon::plan(double x_m, double y_m) const {
  const double x = x_m - eye_x_;
  const double y = y_m - eye_y_;
  return {x * ahead_x_ + y * ahead_y_, x * ahead_y_ - y * ahead_x_};
}

template <typename Corners>
Horizon::Bins Horizon::reach(const Corners& corners) const {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Plan& p : corners) {
    if (p.ahead < kNear) return {0, kBins};
    const double at = (p.right / p.ahead - u_low_) * bins_per_u_;
    low = std::min(low, at);
    high = std::max(high, at);
  }
  const auto bin = [](double at) { return static_cast<std::size_t>(std::clamp(at, 0.0, double{kBins})); };
  return {bin(std::floor(low)), bin(std::floor(high) + 1)};
}

bool Horizon::hides(const cache::Box& box) const {
  if (!usable_ || !placed_) return false;
  const std::array<Plan, 4> corners{plan(box.min[0], box.min[1]), plan(box.max[0], box.min[1]),
                                    plan(box.min[0], box.max[1]), plan(box.max[0], box.max[1])};
  const auto [nearest, farthest] = std::ranges::minmax(corners, {}, &Plan::ahead);
  if (nearest.ahead < kNear) return false;
  const double rise = box.max[2] - eye_z_;
  const double top = rise / (rise > 0 ? nearest.ahead : farthest.ahead) + margin_;
  const Bins bins = reach(corners);
  for (std::size_t i = bins.first; i < bins.end; ++i) {
    if (static_cast<double>(v_[i]) < top) return false;
  }
  return bins.first < bins.end;
}

void Horizon::add(const cache::Occluder& occluder, const codec::TreeLayout& layout, double lowered_m) {
  if (!usable_) return;
  if (!occluder.closed) return open(occluder.cells, layout);
  const auto corner = [&](std::int64_t column, std::int64_t row) {
    const auto [x, y] = layout.world(static_cast<double>(column), static_cast<double>(row));
    return plan(x, y);
  };
  const codec::CellRect& c = occluder.cells;
  const Plan begin = corner(c.column0, c.row0);
  const auto step_to = [&](const Plan& end) {
    return Plan{(end.ahead - begin.ahead) / double{kStrips}, (end.right - begin.right) / double{kStrips}};
  };
  const Plan across = step_to(corner(c.column1, c.row0));
  const Plan down = step_to(corner(c.column0, c.row1));
  const auto at = [&](double i, double j) {
    return Plan{begin.ahead + i * across.ahead + j * down.ahead, begin.right + i * across.right + j * down.right};
  };
  const Bins bins = reach(std::array{begin, at(kStrips, 0), at(0, kStrips), at(kStrips, kStrips)});
  // A tile that is narrow in the picture is as flat to it with fewer lines.
  const std::size_t stride = bins.end - bins.first > 64 ? 1 : bins.end - bins.first > 16 ? 2 : 4;
  for (std::size_t i = 0; i < kLines; i += stride) {
    const auto n = static_cast<double>(i);
    add_line(at(0, n), across, occluder.row_lines[i], lowered_m);
    add_line(at(n, 0), down, occluder.column_lines[i], lowered_m);
  }
}

void Horizon::open(const codec::CellRect& cells, const codec::TreeLayout& layout) {
  if (!usable_) return;
  std::array<Plan, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [x, y] = layout.world(static_cast<double>((i & 1U) != 0 ? cells.column1 : cells.column0),
                                     static_cast<double>((i & 2U) != 0 ? cells.row1 : cells.row0));
    corners[i] = plan(x, y);
  }
  const Bins bins = reach(corners);
  for (std::size_t i = bins.first; i < bins.end; ++i) open_[i] = true;
}

void Horizon::add_line(Plan begin, Plan step, const cache::Occluder::Line& heights, double lowered_m) {
  // The points ahead follow each other, and u along a straight line never turns.
  const auto ahead = [&](std::size_t i) { return begin.ahead + static_cast<double>(i) * step.ahead; };
  std::size_t first = 0;
  std::size_t last = kStrips;
  while (first < last && ahead(first) < kNear) ++first;
  while (last > first && ahead(last) < kNear) --last;
  const auto bin = [&](std::size_t i) {
    return ((begin.right + static_cast<double>(i) * step.right) / ahead(i) - u_low_) * bins_per_u_;
  };
  if (ahead(first) < kNear) return;
  const double left = bin(first);
  const double right = bin(last);
  const bool backward = right < left;
  if (std::min(std::max(left, right), double{kBins}) < std::max(std::ceil(std::min(left, right)), 0.0) + 1) return;
  Chain chain;
  for (std::size_t i = first; i <= last; ++i) {
    const double share = 1 / ahead(i);
    const double u = (begin.right + static_cast<double>(i) * step.right) * share;
    const double rise = static_cast<double>(heights[i]) - lowered_m - eye_z_;
    chain[backward ? last - i : i - first] = {(u - u_low_) * bins_per_u_, rise * share};
  }
  raise(std::span(chain).first(last - first + 1));
}

void Horizon::raise(std::span<const ChainPoint> chain) {
  auto [p0, v0] = chain.front();
  auto bin = static_cast<std::size_t>(std::max(p0, 0.0));
  bool whole = p0 <= static_cast<double>(bin);  // The chain comes into this bin at its left end.
  double low = std::numeric_limits<double>::infinity();
  for (const auto& [p1, v1] : chain.subspan(1)) {
    if (p1 > 0) {
      const double slope = p1 > p0 ? (v1 - v0) / (p1 - p0) : 0;
      const auto at = [&](double p) { return v0 + (p - p0) * slope; };
      low = std::min(low, at(std::max(p0, 0.0)));
      for (; static_cast<double>(bin + 1) <= p1; ++bin, whole = true) {
        const double v_end = at(static_cast<double>(bin + 1));
        const double least = std::min(low, v_end);
        if (whole && least > static_cast<double>(v_[bin]) && !open_[bin]) v_[bin] = round_down(least);
        if (bin + 1 == kBins) return;
        low = v_end;
      }
      low = std::min(low, v1);
    }
    p0 = p1;
    v0 = v1;
  }
}

}  // namespace tintree::render
