#include "codec/scalar_grid.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "codec/place_numbers.h"
#include "codec/scalar_pieces.h"
#include "codec/split_fans.h"

namespace tintree::codec {
namespace {

/// Numbers vertices as pieces come to them.
class GridPieces final : public ScalarPieces {
 public:
  GridPieces(const ScalarShape& shape, ScalarGrid& grid) : grid_(&grid) {
    const auto& sides = shape.sides;
    const auto add = [&](std::int32_t x, std::int32_t y) { static_cast<void>(number({x, y})); };
    for (const std::int32_t at : sides[ScalarShape::kNorth]) add(at, 0);
    for (const std::int32_t at : sides[ScalarShape::kEast]) add(shape.width(), at);
    for (const std::int32_t at : sides[ScalarShape::kSouth]) add(at, shape.height());
    for (const std::int32_t at : sides[ScalarShape::kWest]) add(0, at);
    grid.border_count = grid.places.size();
  }

  void cell(const GridPlace& nw, const GridPlace& se) override {
    const std::uint32_t a = number(nw);
    const std::uint32_t d = number(se);
    grid_->triangles.push_back({a, d, number({se.x, nw.y})});
    grid_->triangles.push_back({a, number({nw.x, se.y}), d});
  }
  void fan(const GridPlace& hub, std::span<const GridPlace> around) override {
    const std::uint32_t middle = number(hub);
    const std::uint32_t first = number(around.front());
    std::uint32_t last = first;
    for (std::size_t k = 1; k < around.size(); ++k) {
      const std::uint32_t next = number(around[k]);
      grid_->triangles.push_back({middle, last, next});
      last = next;
    }
    grid_->triangles.push_back({middle, last, first});
  }
  void triangle(const GridPlace& a, const GridPlace& b, const GridPlace& c) override {
    const std::uint32_t i = number(a);
    const std::uint32_t j = number(b);
    grid_->triangles.push_back({i, j, number(c)});
  }

 private:
  std::uint32_t number(const GridPlace& p) {
    const auto [number, added] = numbers_.add(p.x, p.y);
    if (added) grid_->places.push_back({p.x, p.y, 0});
    return number;
  }

  ScalarGrid* grid_;
  PlaceNumbers numbers_;
};

/// Whether two meshes are the same but for the shape.
bool same(const TileMesh& a, const TileMesh& b) {
  return a.xy_shift == b.xy_shift && a.z_offset == b.z_offset && a.vertices == b.vertices && a.triangles == b.triangles;
}

}  // namespace

std::int64_t cell_count(const ScalarShape& shape) {
  std::int64_t count = 0;
  shape.blocks.for_each([&](const GridBlock& block) {
    const auto along = [&](std::int32_t from, std::int32_t length) {
      return std::min<std::int64_t>(kBlockCells, (std::int64_t{length} - from + block.stride - 1) / block.stride);
    };
    if (!block.empty) count += along(block.x, shape.width()) * along(block.y, shape.height());
  });
  return count;
}

std::optional<ScalarGrid> make_scalar_grid(const ScalarShape& shape) {
  if (cell_count(shape) > kMaxGridVertices) return std::nullopt;
  std::optional<ScalarGrid> grid(std::in_place);
  GridPieces pieces(shape, *grid);
  ScalarPieceWalk walk(shape);
  shape.blocks.for_each([&](const GridBlock& block) {
    if (!block.empty && walk.sound()) walk.visit(block, pieces);
  });
  if (!walk.sound()) grid.reset();
  return grid;
}

TileMesh ScalarTile::mesh(ScalarGrid grid) const {
  TileMesh out;
  out.xy_shift = xy_shift;
  out.z_offset = z_offset;
  out.scalar_shape = shape;
  out.triangles = std::move(grid.triangles);
  out.vertices = std::move(grid.places);
  for (std::size_t i = 0; i < z.size(); ++i) out.vertices[i].z = z[i];
  std::erase_if(out.triangles,
                [&](const Triangle& t) { return is_missing(t[0]) || is_missing(t[1]) || is_missing(t[2]); });
  std::vector<bool> used(z.size(), false);
  for (const Triangle& t : out.triangles) {
    for (const std::uint32_t i : t) used[i] = true;
  }
  if (std::ranges::find(used, false) == used.end()) return out;
  std::vector<std::uint32_t> number(z.size(), 0);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!used[i]) continue;
    out.vertices[count] = out.vertices[i];
    number[i] = count++;
  }
  out.vertices.resize(count);
  for (Triangle& t : out.triangles) t = {number[t[0]], number[t[1]], number[t[2]]};
  split_fans(out);
  return out;
}

std::optional<FoundScalarTile> find_scalar_tile(const TileMesh& mesh) {
  if (!mesh.scalar_shape) return std::nullopt;
  auto grid = make_scalar_grid(*mesh.scalar_shape);
  if (!grid) return std::nullopt;
  ScalarTile tile{*mesh.scalar_shape, mesh.xy_shift, mesh.z_offset, {}, {}};
  std::size_t next = 0;
  for (const GridVertex& place : grid->places) {
    const bool there =
        next < mesh.vertices.size() && mesh.vertices[next].x == place.x && mesh.vertices[next].y == place.y;
    tile.missing.push_back(!there);
    tile.z.push_back(there ? mesh.vertices[next++].z : 0);
  }
  if (std::ranges::find(tile.missing, true) == tile.missing.end()) tile.missing.clear();
  if (!same(tile.mesh(*grid), mesh)) return std::nullopt;
  return FoundScalarTile{std::move(tile), std::move(*grid)};
}

std::array<double, 16> inverse_quantization(const GridBlock& block, std::int32_t step, std::int32_t offset) {
  const auto s = static_cast<double>(block.stride);
  return {s,
          0,
          0,
          0,
          0,
          s,
          0,
          0,
          0,
          0,
          static_cast<double>(step),
          0,
          static_cast<double>(block.x),
          static_cast<double>(block.y),
          static_cast<double>(offset),
          1};
}

}  // namespace tintree::codec
