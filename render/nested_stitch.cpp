#include "render/nested_stitch.h"

#include <algorithm>

namespace tintree::render {

std::vector<std::array<StitchCorner, 3>> stitch(std::span<const BorderVertex> one,
                                                std::span<const BorderVertex> other) {
  std::vector<std::array<StitchCorner, 3>> out;
  if (one.size() < 2 || other.size() < 2) return out;
  const auto size = static_cast<std::ptrdiff_t>(other.size());
  const auto first = std::ranges::upper_bound(other, one.front().along, {}, &BorderVertex::along) - other.begin();
  const auto last = std::ranges::lower_bound(other, one.back().along, {}, &BorderVertex::along) - other.begin();
  const auto from = std::clamp<std::ptrdiff_t>(first - 2, 0, size - 1);
  const auto to = std::clamp<std::ptrdiff_t>(last + 1, 0, size - 1);
  std::size_t i = 0;
  auto j = static_cast<std::size_t>(from);
  while (i + 1 < one.size() || j < static_cast<std::size_t>(to)) {
    // The next of the two ends that comes first.
    const bool ahead =
        j >= static_cast<std::size_t>(to) || (i + 1 < one.size() && one[i + 1].along <= other[j + 1].along);
    const StitchCorner next = ahead ? StitchCorner{one[i + 1].vertex, false} : StitchCorner{other[j + 1].vertex, true};
    out.push_back({StitchCorner{one[i].vertex, false}, StitchCorner{other[j].vertex, true}, next});
    ++(ahead ? i : j);
  }
  return out;
}

}  // namespace tintree::render
