#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"
#include "simplify/reference_surface.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

/// A made-up DEM: the surface as the code under test sees it, and the same heights in a plain array.
struct Terrain {
  HeightGrid grid;
  std::unique_ptr<simplify::ReferenceSurface> surface;
};

/// Heights are rounded to 1/64 m, so that they pass through 32-bit storage unchanged.
Terrain make_terrain(int columns, int rows, const HeightFunction& height);
/// Heights as they are, in double precision.
Terrain make_exact_terrain(int columns, int rows, const HeightFunction& height);
Terrain read_terrain(const std::string& path);

/// Between the lowest and the highest sample; 1 where there is nothing between.
double relief_m(const HeightGrid& grid);

/// A layout for a terrain with the height steps that a build would choose; fails where the build would.
Expected<codec::TreeLayout> plan_layout(const Terrain& terrain, int tile_cells, double leaf_error_m,
                                        int levels_per_doubling = 1);
/// The same; throws std::runtime_error.
codec::TreeLayout make_layout(const Terrain& terrain, int tile_cells, double leaf_error_m, int levels_per_doubling = 1);

/// Every tile of the layout, whether or not it holds surface.
std::vector<codec::TileId> tiles_of(const codec::TreeLayout& layout);

/// One corner of a triangle: column, row, height.
using Corner = std::array<double, 3>;

/// What the overlay of a mesh with the reference surface shows. Every triangle of the mesh is clipped
/// against every half cell of the surface that it reaches; on each piece both are planar, so the pieces'
/// corners have the largest difference, and their areas tell what is covered.
struct Overlay {
  double max_m = 0;         ///< Largest vertical distance.
  double border_max_m = 0;  ///< The same along the sides of the tile's full square.
  double rms_m = 0;         ///< Over the samples that the mesh covers.
  std::uint64_t samples = 0;
  /// Largest error in the coverage of a half cell of the square, in cells: what the surface has must be covered once
  /// and what it lacks not at all. Touching along a side is not covering.
  double coverage_error = 0;
};

Overlay overlay(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                const codec::TileMesh& mesh);

/// What a mesh has to be by itself, checked by brute force: valid addresses, positive triangles, a 2-manifold,
/// the area of the surface's triangles to the last bit.
void expect_sound_mesh(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                       const codec::TileMesh& mesh);

/// Everything that a tile promises: a sound mesh, or none where there is no surface, exact coverage, vertical
/// distance within the bound, a codec that keeps it.
void expect_sound_tile(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                       const codec::TileMesh& mesh, const std::string& method = "tin");

/// Half cells of the reference surface in a rectangle.
std::int64_t half_cells(const HeightGrid& grid, const codec::CellRect& cells);

}  // namespace tintree::test
