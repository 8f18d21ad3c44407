#include "cache/tile_relief.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/wavelet_tiles.h"

namespace tintree::cache {
namespace {

using codec::kPatchMargin;

/// A place in half samples of the DEM from the tile's north-west corner.
using Place = std::array<std::int64_t, 2>;

/// Which samples of a patch a mesh covers. Those of the margin count as the nearest of the tile's own.
class Coverage {
 public:
  Coverage(int shift, int side)
      : spacing_(std::int64_t{2} << shift),
        first_((std::int64_t{1} << shift) - 1 - spacing_ * kPatchMargin),
        side_(side),
        out_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}

  void add(const std::array<Place, 3>& t) {
    const auto [west, east] = std::minmax({t[0][0], t[1][0], t[2][0]});
    const auto [north, south] = std::minmax({t[0][1], t[1][1], t[2][1]});
    for (std::int64_t y = at_least(north); y <= at_most(south); ++y) {
      for (std::int64_t x = at_least(west); x <= at_most(east); ++x) {
        const Place p{first_ + spacing_ * x, first_ + spacing_ * y};
        const bool inside = left_of(t[0], t[1], p) && left_of(t[1], t[2], p) && left_of(t[2], t[0], p);
        if (inside) at(x, y) = 1;
      }
    }
  }

  std::vector<std::uint8_t> take() {
    const auto own = [this](std::int64_t i) {
      return std::clamp<std::int64_t>(i, kPatchMargin, side_ - 1 - kPatchMargin);
    };
    for (std::int64_t y = 0; y < side_; ++y) {
      for (std::int64_t x = 0; x < side_; ++x) at(x, y) |= at(own(x), own(y));
    }
    return std::move(out_);
  }

 private:
  std::uint8_t& at(std::int64_t x, std::int64_t y) { return out_[static_cast<std::size_t>(y * side_ + x)]; }
  /// Samples from, and to, a place that is not before the patch's first.
  std::int64_t at_least(std::int64_t place) const { return (place - first_ + spacing_ - 1) / spacing_; }
  std::int64_t at_most(std::int64_t place) const {
    return std::min<std::int64_t>((place - first_) / spacing_, side_ - 1);
  }
  /// Of the way from a to b, seen from above; y runs southward.
  static bool left_of(const Place& a, const Place& b, const Place& p) {
    return (b[0] - a[0]) * (p[1] - a[1]) <= (b[1] - a[1]) * (p[0] - a[0]);
  }

  std::int64_t spacing_;
  std::int64_t first_;
  std::int64_t side_;
  std::vector<std::uint8_t> out_;
};

/// Whether the mesh covers all cells of the tile that the raster has.
bool is_whole(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh) {
  const codec::CellRect cells = layout.cells(id);
  std::int64_t doubled = 0;
  for (const codec::Triangle& t : mesh.triangles)
    doubled += codec::doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
  const std::int64_t all = 2 * (cells.column1 - cells.column0) * (cells.row1 - cells.row0);
  return doubled << 2 * mesh.xy_shift == all;
}

std::vector<std::uint8_t> covered(const codec::TileMesh& mesh, int shift, int side) {
  Coverage coverage(shift, side);
  const auto place = [&mesh](std::uint32_t i) -> Place {
    const codec::GridVertex& v = mesh.vertices[i];
    return {std::int64_t{v.x} << (mesh.xy_shift + 1), std::int64_t{v.y} << (mesh.xy_shift + 1)};
  };
  for (const codec::Triangle& t : mesh.triangles) coverage.add({place(t[0]), place(t[1]), place(t[2])});
  return coverage.take();
}

/// From height units a spacing, along columns and rows, to slopes east and north.
std::array<float, 4> slope_matrix(const codec::TreeLayout& layout, const codec::TileId& id) {
  const double unit_m = layout.z_step_m[static_cast<std::size_t>(id.level)] / codec::kUnitsAStep;
  const auto& a = layout.axes.column;
  const auto& b = layout.axes.row;
  const double det = a[0] * b[1] - a[1] * b[0];
  const double across = std::ldexp(unit_m / layout.dx_m, id.level - layout.leaf_level) / det;
  const double down = std::ldexp(unit_m / layout.dy_m, id.level - layout.leaf_level) / det;
  return {static_cast<float>(b[1] * across), static_cast<float>(-b[0] * across), static_cast<float>(-a[1] * down),
          static_cast<float>(a[0] * down)};
}

}  // namespace

TileRelief make_tile_relief(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                            codec::PatchResidual residual) {
  TileRelief out;
  const int shift = layout.leaf_level - id.level;
  const int side = residual.side;
  out.residual = std::move(residual);
  if (id.level > 0) out.parent = layout.parent(id);
  out.has_children = shift > 0;
  out.quadrant = static_cast<int>((id.x & 1) | (id.y & 1) << 1);
  const auto sample = [&](std::uint32_t tile, std::int64_t of_layer) {
    return static_cast<int>(
        std::clamp<std::int64_t>(of_layer - std::int64_t{tile} * layout.tile_cells + kPatchMargin, 0, side - 1));
  };
  out.on_raster = {sample(id.x, 0), sample(id.y, 0), sample(id.x, (layout.columns - 1) >> shift),
                   sample(id.y, (layout.rows - 1) >> shift)};
  if (!is_whole(layout, id, mesh)) out.surface = covered(mesh, shift, side);
  out.node_shift = static_cast<float>(0.5 - std::ldexp(0.5, -shift));
  out.slopes = slope_matrix(layout, id);
  return out;
}

}  // namespace tintree::cache
