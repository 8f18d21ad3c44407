#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "codec/grid_frame.h"

namespace tintree::audit {

/// Width and height of a picture of a rectangle's samples: a pixel each, or fewer, so that the longer side has
/// `longest_px` at most; neither has less than `least_px`.
inline std::array<int, 2> picture_size(const codec::CellRect& cells, int longest_px, int least_px) {
  const std::int64_t columns = cells.column1 - cells.column0 + 1;
  const std::int64_t rows = cells.row1 - cells.row0 + 1;
  const std::int64_t longest = std::max(columns, rows);
  const auto side = [&](std::int64_t samples) {
    const std::int64_t px = longest <= longest_px ? samples : (samples * longest_px + longest / 2) / longest;
    return static_cast<int>(std::max<std::int64_t>(px, least_px));
  };
  return {side(columns), side(rows)};
}

}  // namespace tintree::audit
