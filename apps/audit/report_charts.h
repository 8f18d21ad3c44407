#pragma once

#include <string>

#include "apps/audit/tree_audit.h"

namespace tintree::audit {

/// How the samples' errors spread between 0 and the bound, as inline SVG: bars, and a line at the 99.9th
/// percentile.
std::string histogram_svg(const LevelReport& level);

/// A bar of `share` (0 to 1) of its cell, as inline SVG.
std::string bar_svg(double share);

}  // namespace tintree::audit
