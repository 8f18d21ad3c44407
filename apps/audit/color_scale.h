#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "apps/audit/error_map.h"
#include "apps/common/png_image.h"

namespace tintree::audit {

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis at `share` (0 to 1), evenly readable with every kind of colour vision and in grey; beyond 1, and only
/// there, magenta.
Rgb error_color(double share);

/// What is drawn where there is no surface.
inline constexpr Rgb kNoSurface{205, 220, 236};
inline constexpr Rgb kBeyond{214, 0, 110};

/// The map in these colours, errors as shares of `bound_m`.
app::RgbImage draw_map(const ErrorMap& map, double bound_m);

/// The scale as a CSS gradient, for a legend.
std::string scale_css();

}  // namespace tintree::audit
