#include "apps/audit/color_scale.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace tintree::audit {
namespace {

/// Ten of the 256 colours of matplotlib's viridis, evenly spaced.
constexpr std::array<Rgb, 10> kViridis{{{68, 1, 84},
                                        {72, 40, 120},
                                        {62, 73, 137},
                                        {49, 104, 142},
                                        {38, 130, 142},
                                        {31, 158, 137},
                                        {53, 183, 121},
                                        {110, 206, 88},
                                        {181, 222, 43},
                                        {253, 231, 37}}};
constexpr double kRounding = 1e-6;
/// Steps in which pictures show shares: no eye tells more apart, and a page of maps is half as large.
constexpr double kSteps = 32;

}  // namespace

Rgb error_color(double share) {
  if (std::isnan(share)) return kNoSurface;
  if (share > 1 + kRounding) return kBeyond;
  const double at =
      std::round(std::clamp(share, 0.0, 1.0) * kSteps) / kSteps * static_cast<double>(kViridis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  const double part = at - static_cast<double>(low);
  Rgb out{};
  for (std::size_t k = 0; k < 3; ++k) {
    out[k] =
        static_cast<std::uint8_t>(std::lround(kViridis[low][k] + part * (kViridis[low + 1][k] - kViridis[low][k])));
  }
  return out;
}

app::RgbImage draw_map(const ErrorMap& map, double bound_m) {
  app::RgbImage image(map.width_px(), map.height_px());
  for (int y = 0; y < map.height_px(); ++y) {
    for (int x = 0; x < map.width_px(); ++x) {
      const Rgb color = error_color(static_cast<double>(map.at(x, y)) / bound_m);
      std::ranges::copy(color, image.at(x, y));
    }
  }
  return image;
}

std::string scale_css() {
  std::string out = "linear-gradient(to right";
  for (const Rgb& c : kViridis) fmt::format_to(std::back_inserter(out), ",#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
  return out + ")";
}

}  // namespace tintree::audit
