#include "apps/audit/window_bins.h"

#include <algorithm>
#include <array>
#include <bit>

#include "apps/audit/height_window.h"

namespace tintree::audit {

WindowBins::Grid::Grid(const TileSurface& s)
    : width(s.cells.column1 - s.cells.column0),
      height(s.cells.row1 - s.cells.row0),
      nx((width + kWindowCells - 1) / kWindowCells),
      ny((height + kWindowCells - 1) / kWindowCells),
      shift(std::countr_zero(static_cast<std::uint64_t>(kWindowCells * s.units))) {}

template <typename Visit>
void WindowBins::Grid::touched(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1,
                               const Visit& visit) const {
  // Windows share their sides: what ends on one belongs to both.
  const std::int64_t i0 = std::clamp<std::int64_t>((x0 - 1) >> shift, 0, nx - 1);
  const std::int64_t j0 = std::clamp<std::int64_t>((y0 - 1) >> shift, 0, ny - 1);
  const std::int64_t i1 = std::clamp<std::int64_t>(x1 >> shift, 0, nx - 1);
  const std::int64_t j1 = std::clamp<std::int64_t>(y1 >> shift, 0, ny - 1);
  for (std::int64_t j = j0; j <= j1; ++j) {
    for (std::int64_t i = i0; i <= i1; ++i) visit(static_cast<std::size_t>(j * nx + i));
  }
}

template <typename Corners>
Buckets WindowBins::Grid::file(const TileSurface& s, std::size_t count, const Corners& corners_of) const {
  if (nx * ny == 1) return Buckets(count);
  return Buckets(static_cast<std::size_t>(nx * ny), [&](const auto& put) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto corners = corners_of(i);
      const Corner& first = s.corners[corners[0]];
      std::int32_t x0 = first.x;
      std::int32_t y0 = first.y;
      std::int32_t x1 = x0;
      std::int32_t y1 = y0;
      for (const std::uint32_t v : corners) {
        const Corner& p = s.corners[v];
        x0 = std::min(x0, p.x);
        x1 = std::max(x1, p.x);
        y0 = std::min(y0, p.y);
        y1 = std::max(y1, p.y);
      }
      touched(x0, y0, x1, y1, [&](std::size_t w) { put(w, i); });
    }
  });
}

WindowBins::WindowBins(const TileSurface& s)
    : grid_(s),
      triangles_(grid_.file(s, s.triangles.size(), [&s](std::uint32_t t) { return s.triangles[t]; })),
      edges_(grid_.file(s, s.edges.size(),
                        [&s](std::uint32_t e) {
                          return std::array{s.edges[e].a, s.edges[e].b};
                        })),
      corners_(count(), [&](const auto& put) {
        for (std::uint32_t v = 0; v < s.corners.size(); ++v) {
          const Corner& p = s.corners[v];
          if (p.x > s.width_units() || p.y > s.height_units()) continue;
          const std::int64_t i = std::min<std::int64_t>(p.x >> grid_.shift, grid_.nx - 1);
          const std::int64_t j = std::min<std::int64_t>(p.y >> grid_.shift, grid_.ny - 1);
          put(static_cast<std::size_t>(j * grid_.nx + i), v);
        }
      }) {}

codec::CellRect WindowBins::cells(std::size_t window) const {
  const std::int64_t column0 = static_cast<std::int64_t>(window) % grid_.nx * kWindowCells;
  const std::int64_t row0 = static_cast<std::int64_t>(window) / grid_.nx * kWindowCells;
  return {column0, row0, std::min(column0 + kWindowCells, grid_.width), std::min(row0 + kWindowCells, grid_.height)};
}

}  // namespace tintree::audit
