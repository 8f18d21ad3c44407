#include "simplify/scalar_levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "codec/tile_mesh.h"

namespace tintree::simplify {
namespace {

/// Samples along a side that a histogram looks at.
constexpr std::int32_t kMostAcross = 1024;
/// Of Lloyd's, enough for levels that get rounded to steps.
constexpr int kMostIterations = 50;

/// Calls `visit` with what is there of every `stride`-th sample inside, in height steps.
template <typename Visit>
void for_each_height(SurfaceView& view, const ScalarSpec& spec, const Visit& visit) {
  std::int32_t stride = 1;
  while (std::max(spec.width(), spec.height()) / stride > kMostAcross) stride *= 2;
  for (std::int32_t y = stride; y < spec.height() && !view.interrupted(); y += stride) {
    for (std::int32_t x = stride; x < spec.width(); x += stride) {
      const double h = view.sample(spec.column0 + x, spec.row0 + y);
      if (!std::isnan(h)) visit(spec.level.heights.address(h));
    }
  }
}

/// Calls `visit` with the middles of the fewest intervals of `most_off` on either side that hold all heights that are
/// farther than that from the `levels`, which rise.
template <typename Visit>
void for_each_gap(const HeightHistogram& histogram, const std::vector<std::int64_t>& levels, std::int64_t most_off,
                  const Visit& visit) {
  auto above = levels.begin();
  std::int64_t reached = -1;
  for (const codec::HeightWeight& h : histogram.heights) {
    const auto z = std::llround(h.height_m);
    above = std::find_if(above, levels.end(), [z](std::int64_t level) { return level >= z; });
    const bool near =
        (above != levels.end() && *above - z <= most_off) || (above != levels.begin() && z - above[-1] <= most_off);
    if (near || z <= reached) continue;
    visit(z + most_off);
    reached = z + 2 * most_off;
  }
}

}  // namespace

HeightHistogram height_histogram(SurfaceView& view, const ScalarSpec& spec) {
  HeightHistogram out;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  for_each_height(view, spec, [&](std::int64_t z) {
    lowest = std::min(lowest, z);
    highest = std::max(highest, z);
  });
  if (lowest > highest || highest - lowest > codec::kMaxHeightAddress) return out;
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(highest - lowest) + 1);
  for_each_height(view, spec, [&](std::int64_t z) { ++counts[static_cast<std::size_t>(z - lowest)]; });
  out.lowest = lowest;
  for (std::size_t z = 0; z < counts.size(); ++z) {
    if (counts[z] > 0) out.heights.push_back({static_cast<double>(z), static_cast<double>(counts[z])});
  }
  return out;
}

std::vector<std::int64_t> lloyd_max_levels(const HeightHistogram& histogram, std::int64_t most_off) {
  std::size_t fewest = 0;
  for_each_gap(histogram, {}, most_off, [&](std::int64_t) { ++fewest; });
  std::vector<std::int64_t> out;
  for (const double value : codec::lloyd_max_quantizer(histogram.heights, fewest, kMostIterations).quantizer.values_m)
    out.push_back(std::llround(value));
  std::vector<std::int64_t> more;
  for_each_gap(histogram, out, most_off, [&](std::int64_t level) { more.push_back(level); });
  out.insert(out.end(), more.begin(), more.end());
  std::ranges::sort(out);
  out.erase(std::ranges::unique(out).begin(), out.end());
  for (std::int64_t& level : out) level += histogram.lowest;
  return out;
}

}  // namespace tintree::simplify
