#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "render/terrain_scene.h"

namespace tintree::test {

inline render::Camera camera_at(const glm::dvec3& eye, const glm::dvec3& target, int width_px, int height_px) {
  render::Camera c;
  c.eye = eye;
  c.target = target;
  c.width_px = width_px;
  c.height_px = height_px;
  return c;
}

/// What a camera sees of a scene.
struct Seen {
  render::Picture picture;
  std::vector<double> depths;  ///< Metres; infinite behind the ground.
  render::DrawStats stats;
};

inline Seen see(render::TerrainScene& scene, const render::OffscreenTarget& target, const render::Camera& camera,
                const render::Style& style) {
  const auto cut = scene.settle(camera);
  EXPECT_TRUE(cut) << cut.error().text();
  Seen out{.picture = {}, .depths = {}, .stats = scene.draw(target, camera, *cut, style)};
  out.picture = target.read_picture();
  const double near_m = scene.renderer().near_m(*cut);
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) out.depths.push_back(near_m / target.read_depth(x, y));
  }
  return out;
}

/// Whether two pictures show one ground in the same light: a twentieth of a pixel in depth, half a grey in the mean.
/// `most_rim`: so many pixels may have ground in one picture alone.
inline testing::AssertionResult look_alike(const Seen& a, const Seen& b, const render::Camera& camera,
                                           std::size_t most_rim = 0) {
  double worst_px = 0;
  double sum = 0;
  std::size_t ground = 0;
  std::size_t rim = 0;
  for (std::size_t i = 0; i < a.depths.size(); ++i) {
    if (std::isfinite(a.depths[i]) != std::isfinite(b.depths[i])) ++rim;
    if (!std::isfinite(a.depths[i]) || !std::isfinite(b.depths[i])) continue;
    ++ground;
    worst_px = std::max(worst_px, std::abs(a.depths[i] - b.depths[i]) * camera.focal_px() / a.depths[i]);
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) sum += std::abs(int{a.picture.rgb[k]} - int{b.picture.rgb[k]});
  }
  const double grey = sum / (3 * static_cast<double>(ground));
  if (ground > a.depths.size() / 4 && rim <= most_rim && worst_px < 0.05 && grey < 0.5)
    return testing::AssertionSuccess();
  return testing::AssertionFailure() << ground << " pixels of ground, " << rim << " of one alone, " << worst_px
                                     << " pixels off, " << grey << " greys";
}

/// Pixels of one colour.
inline int count_color(const render::Picture& p, std::array<std::uint8_t, 3> color) {
  int count = 0;
  for (std::size_t i = 0; i < p.rgb.size(); i += 3)
    count += p.rgb[i] == color[0] && p.rgb[i + 1] == color[1] && p.rgb[i + 2] == color[2];
  return count;
}

/// Pixels whose colour is none of those, or between those, of the reference's pixels at most one away.
inline int count_strange(const render::Picture& shown, const render::Picture& reference, int tolerance) {
  int count = 0;
  for (int y = 0; y < shown.height_px; ++y) {
    for (int x = 0; x < shown.width_px; ++x) {
      bool strange = false;
      for (std::size_t k = 0; k < 3; ++k) {
        int low = 255, high = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, shown.height_px - 1); ++v) {
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, shown.width_px - 1); ++u) {
            low = std::min<int>(low, reference.at(u, v)[k]);
            high = std::max<int>(high, reference.at(u, v)[k]);
          }
        }
        const int value = shown.at(x, y)[k];
        strange = strange || value < low - tolerance || value > high + tolerance;
      }
      count += strange ? 1 : 0;
    }
  }
  return count;
}

}  // namespace tintree::test
