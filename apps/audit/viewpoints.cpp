#include "apps/audit/viewpoints.h"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <fmt/format.h>

namespace tintree::audit {
namespace {

constexpr std::uint32_t kSeed = 20040901;
constexpr double kPi = std::numbers::pi;
constexpr double kMargin = 1.05;
/// Of render::Camera::vertical_gain() for pictures of this shape.
constexpr double kMostGain = 1.2;
constexpr double kFlightPitch = 0.6;

class Chooser {
 public:
  Chooser(const codec::TreeLayout& layout, double highest_m, const ImageOptions& options)
      : layout_(layout), highest_m_(highest_m), options_(options) {
    const render::Camera camera = blank();
    // A tile counts as near as its nearest visible point may be, in the picture's corner; a vertical metre moves a
    // point by at most kMostGain metres across the view.
    const double corner = std::hypot(1.0, camera.tan_half_x(), camera.tan_half_y());
    lowest_m_ = kMargin * kMostGain * corner * layout.leaf_error_m * camera.focal_px() / options.pixel_error;
  }

  Viewpoint flight(int i) const {
    const double share = options_.flight_views > 1 ? static_cast<double>(i) / (options_.flight_views - 1) : 0.5;
    const double height_m = lowest_m_ * (1 + 3 * std::abs(2 * share - 1));
    return look(fmt::format("flight {}", i + 1), 0.2 + 0.6 * share, 0.8 - 0.6 * share, heading(), kFlightPitch,
                height_m);
  }

  Viewpoint random(int i, std::mt19937& random) const {
    const auto dice = [&random] { return static_cast<double>(random()) / 4294967296.0; };
    const double x = 0.15 + 0.7 * dice();
    const double y = 0.15 + 0.7 * dice();
    const double azimuth = 2 * kPi * dice();
    const double pitch = 0.12 + 1.4 * dice();
    return look(fmt::format("random {}", i + 1), x, y, azimuth, pitch, lowest_m_ * std::pow(6, dice()));
  }

 private:
  render::Camera blank() const {
    render::Camera camera;
    camera.width_px = options_.width_px;
    camera.height_px = options_.height_px;
    return camera;
  }

  /// A point of the ground at shares (x, y) of the terrain along its columns' and its rows' way.
  glm::dvec3 ground(double x, double y) const {
    const auto [east_m, north_m] =
        layout_.world(x * static_cast<double>(layout_.columns - 1), y * static_cast<double>(layout_.rows - 1));
    return {east_m, north_m, highest_m_};
  }

  /// From the south-west corner to the north-east one, clockwise from north.
  double heading() const {
    const glm::dvec3 way = ground(1, 0) - ground(0, 1);
    return std::atan2(way.x, way.y);
  }

  /// Towards the ground at the shares (x, y) of the terrain, `pitch` below the horizon.
  Viewpoint look(std::string name, double x, double y, double azimuth, double pitch, double height_m) const {
    Viewpoint view{std::move(name), blank()};
    const glm::dvec3 along(std::sin(azimuth), std::cos(azimuth), 0);
    view.camera.target = ground(x, y);
    view.camera.eye = view.camera.target - along * (height_m / std::tan(pitch)) + glm::dvec3(0, 0, height_m);
    return view;
  }

  const codec::TreeLayout& layout_;
  double highest_m_;
  double lowest_m_ = 0;
  const ImageOptions& options_;
};

}  // namespace

std::vector<Viewpoint> choose_viewpoints(const codec::TreeLayout& layout, double highest_m,
                                         const ImageOptions& options) {
  const Chooser chooser(layout, highest_m, options);
  std::vector<Viewpoint> views;
  for (int i = 0; i < options.flight_views; ++i) views.push_back(chooser.flight(i));
  std::mt19937 random(kSeed);
  for (int i = 0; i < options.random_views; ++i) views.push_back(chooser.random(i, random));
  return views;
}

}  // namespace tintree::audit
