#include "codec/grid_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tintree::codec {
namespace {

std::uint32_t tiles_along(std::int64_t samples, std::int64_t cells) {
  return static_cast<std::uint32_t>((samples - 1 + cells - 1) / cells);
}

}  // namespace

std::array<double, 2> GridAxes::grid(double east_m, double north_m) const {
  const double area = column[0] * row[1] - column[1] * row[0];
  return {(east_m * row[1] - north_m * row[0]) / area, (column[0] * north_m - column[1] * east_m) / area};
}

int TreeLayout::leaf_level_for(std::int64_t columns, std::int64_t rows, int tile_cells, int levels_per_doubling) {
  const std::int64_t cells = std::max(columns, rows) - 1;
  int halvings = 0;
  while ((std::int64_t{tile_cells} << halvings) < cells) ++halvings;
  return halvings * levels_per_doubling;
}

double TreeLayout::bound_m(int level) const {
  const int up = leaf_level - level;
  const double doubled = std::ldexp(leaf_error_m, up / levels_per_doubling);
  return up % levels_per_doubling == 0 ? doubled : doubled * std::numbers::sqrt2;
}

TreeLayout TreeLayout::deepened(int halvings) const {
  TreeLayout out = *this;
  out.leaf_level += halvings * levels_per_doubling;
  out.tile_cells >>= halvings;
  return out;
}

TileId TreeLayout::parent(const TileId& id) const {
  const int shift = child_count(id.level - 1) == 4 ? 1 : 0;
  return {id.level - 1, id.x >> shift, id.y >> shift};
}

TileId TreeLayout::child(const TileId& id, int which) const {
  if (child_count(id.level) == 1) return {id.level + 1, id.x, id.y};
  const auto quadrant = static_cast<std::uint32_t>(which);
  return {id.level + 1, 2 * id.x + (quadrant & 1U), 2 * id.y + (quadrant >> 1U)};
}

std::array<double, 2> TreeLayout::grid(double x_m, double y_m) const {
  const auto [across_m, down_m] = axes.grid(x_m - origin_m[0], y_m - origin_m[1]);
  return {across_m / dx_m, down_m / dy_m};
}

std::uint32_t TreeLayout::tiles_x(int level) const { return tiles_along(columns, cells_across(level)); }

std::uint32_t TreeLayout::tiles_y(int level) const { return tiles_along(rows, cells_across(level)); }

CellRect TreeLayout::cells(const TileId& id) const {
  const std::int64_t across = cells_across(id.level);
  const std::int64_t column0 = std::int64_t{id.x} * across;
  const std::int64_t row0 = std::int64_t{id.y} * across;
  return {column0, row0, std::min(column0 + across, columns - 1), std::min(row0 + across, rows - 1)};
}

GridFrame::GridFrame(const TreeLayout& layout, const TileId& id, const TileMesh& mesh)
    : column0(std::int64_t{id.x} * layout.cells_across(id.level)),
      row0(std::int64_t{id.y} * layout.cells_across(id.level)),
      xy_shift(mesh.xy_shift),
      z_offset(mesh.z_offset),
      z_step_m(layout.z_step_m[static_cast<std::size_t>(id.level)]),
      dx_m(layout.dx_m),
      dy_m(layout.dy_m),
      axes(layout.axes),
      origin_m(layout.origin_m) {}

double GridFrame::column(std::int32_t x) const {
  return static_cast<double>(column0) + std::ldexp(static_cast<double>(x), xy_shift);
}

double GridFrame::row(std::int32_t y) const {
  return static_cast<double>(row0) + std::ldexp(static_cast<double>(y), xy_shift);
}

std::array<double, 3> GridFrame::world(const GridVertex& v) const {
  const auto [x, y] = axes.world(column(v.x) * dx_m, row(v.y) * dy_m);
  return {origin_m[0] + x, origin_m[1] + y, height_m(v.z)};
}

std::array<double, 16> GridFrame::matrix(const std::array<double, 3>& eye) const {
  const double step = std::ldexp(1.0, xy_shift);
  const auto across = axes.world(step * dx_m, 0);
  const auto down = axes.world(0, step * dy_m);
  const auto corner = axes.world(static_cast<double>(column0) * dx_m, static_cast<double>(row0) * dy_m);
  const double z0 = static_cast<double>(z_offset) * z_step_m - eye[2];
  return {across[0],
          across[1],
          0,
          0,
          down[0],
          down[1],
          0,
          0,  //
          0,
          0,
          z_step_m,
          0,
          corner[0] + (origin_m[0] - eye[0]),
          corner[1] + (origin_m[1] - eye[1]),
          z0,
          1};
}

}  // namespace tintree::codec
