#include "render/screen_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/geometric.hpp>

namespace tintree::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of a quadrangle less what four planes have cut off, each of which makes half as many corners again at the very most.
constexpr std::size_t kMostCorners = 20;

/// A part of a box's face, in camera axes.
struct Polygon {
  std::array<glm::dvec3, kMostCorners> corners;
  std::size_t size = 0;
};

/// Cuts off a polygon where dot(n, p) < 0.
void clip(Polygon& polygon, const glm::dvec3& n) {
  const auto end = polygon.corners.begin() + static_cast<std::ptrdiff_t>(polygon.size);
  if (std::all_of(polygon.corners.begin(), end, [&](const glm::dvec3& p) { return glm::dot(n, p) >= 0; })) return;
  const Polygon in = polygon;
  Polygon& out = polygon;
  out.size = 0;
  for (std::size_t i = 0; i < in.size; ++i) {
    const glm::dvec3& a = in.corners[i];
    const glm::dvec3& b = in.corners[(i + 1) % in.size];
    const double above_a = glm::dot(n, a);
    const double above_b = glm::dot(n, b);
    if (above_a >= 0) out.corners[out.size++] = a;
    if ((above_a < 0) != (above_b < 0)) out.corners[out.size++] = a + (b - a) * (above_a / (above_a - above_b));
  }
}

}  // namespace

/// A visible point: g, of which vector it is the length, and 1 / Z.
struct ScreenError::Sight {
  glm::dvec2 way;
  double gain;
  double nearness;
};

struct ScreenError::Extremes {
  double nearness = 0;          ///< The largest 1 / Z.
  double gain_by_nearness = 0;  ///< The largest g / Z.
};

ScreenError::ScreenError(const Camera& camera)
    : camera_(camera),
      axes_(camera.axes()),
      focal_px_(camera.focal_px()),
      tan_x_(camera.tan_half_x()),
      tan_y_(camera.tan_half_y()) {}

// Of a displacement let Q be the end in the picture and R the other. With Q's g and R's depth, which is at least Q's
// less error_m |uz|, the shift is at most
//   focal_px error_m (g / Z)(Q) / (1 - error_m |uz| / Z(Q)),
// and Q is in the box made higher by error_m both ways. So the largest g / Z and the largest 1 / Z over the part of
// that box within the frustum bound it. In the coordinates (X, Y, w = 1 / Z) this part is a convex polytope, too; g is
// convex there and does not depend on w. From any of its points g w does not fall on the way to larger w, which ends at
// a face of the box that looks at the eye, and on that face not one of both ways with w unchanged, on which g is
// convex; these end at an edge. So the largest g w lies on an edge of such a face clipped by the frustum.
std::optional<double> ScreenError::bound_px(const cache::Box& box, double error_m) const {
  glm::dvec3 low(box.min[0], box.min[1], box.min[2] - error_m);
  glm::dvec3 high(box.max[0], box.max[1], box.max[2] + error_m);
  low -= camera_.eye;
  high -= camera_.eye;
  Extremes extremes;
  bool seen = false;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const bool below = low[axis] >= 0;
    if (!below && high[axis] > 0) continue;
    inside = false;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    std::array<glm::dvec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i][axis] = below ? low[axis] : high[axis];
      corners[i][u] = i == 1 || i == 2 ? high[u] : low[u];
      corners[i][v] = i >= 2 ? high[v] : low[v];
    }
    seen = add_face(corners, extremes) || seen;
  }
  if (inside) return error_m > 0 ? kInfinity : 0;
  if (!seen) return std::nullopt;
  if (error_m <= 0) return 0;
  const double left = 1 - error_m * std::abs(axes_.forward.z) * extremes.nearness;
  if (!(left > 0)) return kInfinity;
  return focal_px_ * error_m * std::max(extremes.gain_by_nearness, kLeastGain * extremes.nearness) / left;
}

/// False when no part of the face is in the picture.
bool ScreenError::add_face(const std::array<glm::dvec3, 4>& corners, Extremes& out) const {
  Polygon part;
  for (const glm::dvec3& c : corners)
    part.corners[part.size++] = {glm::dot(c, axes_.right), glm::dot(c, axes_.up), glm::dot(c, axes_.forward)};
  for (const glm::dvec3& n :
       {glm::dvec3(1, 0, tan_x_), glm::dvec3(-1, 0, tan_x_), glm::dvec3(0, 1, tan_y_), glm::dvec3(0, -1, tan_y_)})
    clip(part, n);
  if (part.size == 0) return false;
  std::array<Sight, kMostCorners> sights;
  for (std::size_t i = 0; i < part.size; ++i) {
    sights[i] = sight(part.corners[i]);
    out.nearness = std::max(out.nearness, sights[i].nearness);
    out.gain_by_nearness = std::max(out.gain_by_nearness, sights[i].gain * sights[i].nearness);
  }
  for (std::size_t i = 0; i < part.size; ++i)
    out.gain_by_nearness = std::max(out.gain_by_nearness, largest_between(sights[i], sights[(i + 1) % part.size]));
  return true;
}

ScreenError::Sight ScreenError::sight(const glm::dvec3& p) const {
  if (!(p.z > 0)) return {{1, 0}, 1, kInfinity};
  const double uz = axes_.forward.z;
  const glm::dvec2 way(uz * p.x / p.z, axes_.up.z - uz * p.y / p.z);
  return {way, glm::length(way), 1 / p.z};
}

/// The largest g / Z within the edge between two points, 0 where its ends have larger ones: along it in (X, Y, 1 / Z)
/// g² is a quadratic a + b t + c t² and 1 / Z a linear function.
double ScreenError::largest_between(const Sight& from, const Sight& to) {
  // Both change the same way.
  if ((from.gain <= to.gain) == (from.nearness <= to.nearness)) return 0;
  const glm::dvec2 way = to.way - from.way;
  const double a = from.gain * from.gain;
  const double b = 2 * glm::dot(from.way, way);
  const double c = glm::dot(way, way);
  const double w0 = from.nearness;
  const double w1 = to.nearness - from.nearness;
  // Where the derivative of (g / Z)² has a zero: p t² + q t + r = 0.
  const double p = 4 * c * w1;
  const double q = 2 * c * w0 + 3 * b * w1;
  const double r = b * w0 + 2 * a * w1;
  const double discriminant = q * q - 4 * p * r;
  if (!(discriminant > 0)) return 0;
  const double sum = -0.5 * (q + std::copysign(std::sqrt(discriminant), q));
  double largest = 0;
  for (const double t : {sum / p, r / sum}) {
    if (t > 0 && t < 1) largest = std::max(largest, std::sqrt(a + t * (b + t * c)) * (w0 + t * w1));
  }
  return largest;
}

}  // namespace tintree::render
