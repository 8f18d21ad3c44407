#pragma once

#include <cstdint>
#include <vector>

#include "codec/quantizer.h"
#include "simplify/scalar_blocks.h"

namespace tintree::simplify {

/// The heights inside a tile in whole steps, relative to `lowest`, rising, each once with how often it occurs.
struct HeightHistogram {
  std::int64_t lowest = 0;
  std::vector<codec::HeightWeight> heights;
};

/// Of all samples inside a tile; where those are more than a million, of every second, fourth ... column and row. Empty
/// where all are missing, or farther apart than a tile's heights can be. Memory: 4 bytes a step of relief, 16 a height.
HeightHistogram height_histogram(SurfaceView& view, const ScalarSpec& spec);

/// Levels, rising, in steps from height 0, one of which is within `most_off` steps of every height: those of a
/// Lloyd-Max quantiser with as many levels as that takes at least, and where they leave heights farther off, the fewest
/// more that it takes. Two times the fewest at most. Empty for an empty histogram. Cost: about 0.3 us a height.
std::vector<std::int64_t> lloyd_max_levels(const HeightHistogram& histogram, std::int64_t most_off);

}  // namespace tintree::simplify
