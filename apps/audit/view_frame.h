#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <tbb/parallel_for.h>

#include "apps/audit/surface_rays.h"
#include "codec/grid_frame.h"
#include "render/camera.h"

namespace tintree::audit {

/// Where a view's pixels lie in the world and on the DEM's grid. Pixels are numbered row by row from the upper one;
/// what is seen at one is what its centre shows. A plain value.
class ViewFrame {
 public:
  /// `limit_px`: how far things may be off in this view.
  ViewFrame(const codec::TreeLayout& layout, const render::Camera& camera, double limit_px);

  const render::Camera& camera() const { return camera_; }
  double limit_px() const { return limit_px_; }
  std::size_t pixels() const { return static_cast<std::size_t>(camera_.width_px) * height(); }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width_px) + static_cast<std::size_t>(x);
  }

  /// Through a pixel's centre, at depth 1.
  glm::dvec3 ray(std::size_t pixel) const;
  glm::dvec3 point(std::size_t pixel, double depth_m) const { return camera_.eye + depth_m * ray(pixel); }
  /// A point's column and row on the DEM's grid,
  double column(const glm::dvec3& p) const { return layout_.grid(p.x, p.y)[0]; }
  double row(const glm::dvec3& p) const { return layout_.grid(p.x, p.y)[1]; }
  /// and a ray from the eye there; its parameter is the depth.
  GridRay grid_ray(const glm::dvec3& ray) const;

  /// How far apart two points before the eye are in the picture,
  double distance_px(const glm::dvec3& a, const glm::dvec3& b) const;
  /// and what a pixel spans at a depth.
  double footprint_m(double depth_m) const { return depth_m / focal_px_; }

  /// Pixels that an outline may be off,
  int reach() const { return reach_; }
  /// and those so near a pixel, itself among them.
  template <typename Visit>
  void for_near(int x, int y, const Visit& visit) const {
    for (int j = std::max(y - reach_, 0); j <= std::min(y + reach_, camera_.height_px - 1); ++j) {
      for (int i = std::max(x - reach_, 0); i <= std::min(x + reach_, camera_.width_px - 1); ++i) visit(index(i, j));
    }
  }

  /// Calls work(y), which returns an error or nothing, for all rows on all cores. Returns the uppermost error.
  template <typename Work>
  std::optional<Error> each_row(const Work& work) const {
    std::vector<std::optional<Error>> errors(height());
    tbb::parallel_for(0, camera_.height_px, [&](int y) { errors[static_cast<std::size_t>(y)] = work(y); });
    const auto first = std::ranges::find_if(errors, [](const auto& e) { return e.has_value(); });
    return first == errors.end() ? std::nullopt : *first;
  }

 private:
  std::size_t height() const { return static_cast<std::size_t>(camera_.height_px); }

  const codec::TreeLayout& layout_;
  const render::Camera& camera_;
  render::CameraAxes axes_;
  double focal_px_;
  double limit_px_;
  int reach_;
};

/// The full-resolution surface in a view.
struct SeenSurface {
  const ViewFrame& frame;
  const SurfaceRays& rays;
  std::span<const double> depths_m;  ///< Along the view, pixel by pixel; SurfaceRays::kMiss where none is seen.
};

}  // namespace tintree::audit
