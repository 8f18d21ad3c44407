#include "cache/nested_borders.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tintree::cache {
namespace {

/// Which sides a vertex lies on, as indices of NestedShape::borders, and where along them.
class Sides {
 public:
  Sides(const NestedShape& shape, const TileOutline& outline) : shape_(&shape), outline_(&outline) {}

  template <typename Visit>
  void of(std::uint32_t vertex, Visit&& visit) const {
    const std::int64_t x = shape_->vertices[vertex].x();
    const std::int64_t y = shape_->vertices[vertex].y();
    const int digits = shape_->frame.xy_shift + 1;
    const std::int64_t eastward = 2 * shape_->frame.column0 + (x << digits);
    const std::int64_t southward = 2 * shape_->frame.row0 + (y << digits);
    if (x == 0) visit(0, southward);
    if (y == 0) visit(1, eastward);
    if (x == outline_->east) visit(2, southward);
    if (y == outline_->south) visit(3, eastward);
  }

 private:
  const NestedShape* shape_;
  const TileOutline* outline_;
};

/// Visits the edges of all triangles of a level.
template <typename Visit>
void for_edges(const std::vector<std::uint32_t>& fans, Visit&& visit) {
  std::size_t centre = 0;
  for (std::size_t i = 0; i < fans.size(); ++i) {
    if (fans[i] == codec::NestedFans::kRestart) centre = i + 1;
    if (i < centre + 2) continue;
    visit(fans[centre], fans[i - 1]);
    visit(fans[i - 1], fans[i]);
    visit(fans[i], fans[centre]);
  }
}

}  // namespace

void add_nested_borders(NestedShape& shape, const TileOutline& outline) {
  const Sides sides(shape, outline);
  for (std::uint32_t v = 0; v < shape.vertices.size(); ++v)
    sides.of(v, [&](std::size_t side, std::int64_t along) { shape.borders[side].push_back({along, v, 0}); });
  for (auto& border : shape.borders) std::ranges::sort(border, {}, &BorderVertex::along);
  for (int level = 0; level < NestedShape::kLevels; ++level) {
    for_edges(shape.level_fans(level), [&](std::uint32_t a, std::uint32_t b) {
      sides.of(a, [&](std::size_t side_of_a, std::int64_t along_a) {
        sides.of(b, [&](std::size_t side_of_b, std::int64_t along_b) {
          if (side_of_a != side_of_b) return;
          const auto first =
              std::ranges::lower_bound(shape.borders[side_of_a], std::min(along_a, along_b), {}, &BorderVertex::along);
          first->joined_levels |= static_cast<std::uint16_t>(1U << level);
        });
      });
    });
  }
}

}  // namespace tintree::cache
