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

Horizon::Horizon(const Camera& camera) : eye_x_(camera.eye.x), eye_y_(camera.eye.y), eye_z_(camera.eye.z) {
  v_.fill(-std::numeric_limits<float>::infinity());
  const CameraAxes axes = camera.axes();
  // The picture's right is level, so this is the view's own azimuth.
  ahead_x_ = -axes.right.y;
  ahead_y_ = axes.right.x;
  double u_high = -std::numeric_limits<double>::infinity();
  u_low_ = -u_high;
  usable_ = true;
  for (const double x : {0.0, static_cast<double>(camera.width_px)}) {
    for (const double y : {0.0, static_cast<double>(camera.height_px)}) {
      const glm::dvec3 ray = camera.ray(x, y);
      const double ahead = ray.x * ahead_x_ + ray.y * ahead_y_;
      const double right = ray.x * axes.right.x + ray.y * axes.right.y;
      if (ahead < kLeastAhead * std::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z)) usable_ = false;
      u_low_ = std::min(u_low_, right / ahead);
      u_high = std::max(u_high, right / ahead);
    }
  }
  if (!usable_) return;
  bins_per_u_ = static_cast<double>(kBins) / (u_high - u_low_);
  margin_ = kMarginPx / camera.focal_px();
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
  for (std::size_t i = 0; i < kLines; ++i) {
    const auto n = static_cast<double>(i);
    add_line({begin.ahead + n * down.ahead, begin.right + n * down.right}, across, occluder.row_lines[i], lowered_m);
    add_line({begin.ahead + n * across.ahead, begin.right + n * across.right}, down, occluder.column_lines[i],
             lowered_m);
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
  std::array<std::array<double, 2>, kLines> chain;
  std::size_t points = 0;
  // The points ahead follow each other, and u along a straight line never turns.
  for (std::size_t i = 0; i < kLines; ++i) {
    const double ahead = begin.ahead + static_cast<double>(i) * step.ahead;
    if (ahead < kNear) continue;
    const double right = begin.right + static_cast<double>(i) * step.right;
    const double z = static_cast<double>(heights[i]) - lowered_m - eye_z_;
    chain[points++] = {(right / ahead - u_low_) * bins_per_u_, z / ahead};
  }
  if (points < 2) return;
  if (chain[0][0] > chain[points - 1][0]) std::reverse(chain.begin(), chain.begin() + static_cast<long>(points));
  raise(chain, points);
}

void Horizon::raise(const std::array<std::array<double, 2>, kLines>& chain, std::size_t points) {
  auto [p0, v0] = chain[0];
  if (p0 >= double{kBins} || chain[points - 1][0] < std::max(std::ceil(p0), 0.0) + 1) return;
  auto bin = static_cast<std::size_t>(std::max(p0, 0.0));
  bool whole = p0 <= static_cast<double>(bin);  // The chain comes into this bin at its left end.
  double low = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < points; ++i) {
    const auto [p1, v1] = chain[i];
    if (p1 > 0) {
      const double slope = p1 > p0 ? (v1 - v0) / (p1 - p0) : 0;
      const auto at = [&](double p) { return v0 + (p - p0) * slope; };
      low = std::min(low, at(std::max(p0, 0.0)));
      for (; static_cast<double>(bin + 1) <= p1; ++bin, whole = true) {
        const double v_end = at(static_cast<double>(bin + 1));
        if (whole && !open_[bin]) v_[bin] = std::max(v_[bin], round_down(std::min(low, v_end)));
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
