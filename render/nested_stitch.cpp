#include "render/nested_stitch.h"

#include <algorithm>

namespace tintree::render {

std::vector<std::array<StitchCorner, 3>> stitch(std::span<const BorderVertex> one,
                                                std::span<const BorderVertex> other) {
  std::vector<std::array<StitchCorner, 3>> out;
  if (one.size() < 2 || other.size() < 2) return out;
  if (one.back().along <= other.front().along || other.back().along <= one.front().along) return out;
  const auto before = [](std::span<const BorderVertex> line, const BorderVertex& v) {
    return std::ranges::upper_bound(line, v.along, {}, &BorderVertex::along) - line.begin() - 1;
  };
  const auto behind = [](std::span<const BorderVertex> line, const BorderVertex& v) {
    return std::ranges::lower_bound(line, v.along, {}, &BorderVertex::along) - line.begin();
  };
  const auto index = [](std::span<const BorderVertex> line, std::ptrdiff_t i) {
    return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(line) - 1));
  };
  std::size_t i = index(one, before(one, other.front()));
  const std::size_t last = index(one, behind(one, other.back()));
  std::size_t j = index(other, before(other, one.front()) - 1);
  const std::size_t to = index(other, behind(other, one.back()) + 1);
  while (i < last || j < to) {
    // The next of the two ends that comes first.
    const bool ahead = j >= to || (i < last && one[i + 1].along <= other[j + 1].along);
    const StitchCorner next = ahead ? StitchCorner{one[i + 1].vertex, false} : StitchCorner{other[j + 1].vertex, true};
    out.push_back({StitchCorner{one[i].vertex, false}, StitchCorner{other[j].vertex, true}, next});
    ++(ahead ? i : j);
  }
  return out;
}

}  // namespace tintree::render
