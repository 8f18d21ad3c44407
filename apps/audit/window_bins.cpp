#include "apps/audit/window_bins.h"

#include <algorithm>
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

WindowBins::WindowBins(const TileSurface& s)
    : grid_(s),
      triangles_(count(),
                 [&](const auto& put) {
                   for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
                     const Corner& a = s.corners[s.triangles[t][0]];
                     const Corner& b = s.corners[s.triangles[t][1]];
                     const Corner& c = s.corners[s.triangles[t][2]];
                     const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
                     const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
                     grid_.touched(x0, y0, x1, y1, [&](std::size_t w) { put(w, t); });
                   }
                 }),
      edges_(count(),
             [&](const auto& put) {
               for (std::uint32_t e = 0; e < s.edges.size(); ++e) {
                 const Corner& a = s.corners[s.edges[e].a];
                 const Corner& b = s.corners[s.edges[e].b];
                 const auto [x0, x1] = std::minmax(a.x, b.x);
                 const auto [y0, y1] = std::minmax(a.y, b.y);
                 grid_.touched(x0, y0, x1, y1, [&](std::size_t w) { put(w, e); });
               }
             }),
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
