#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/tile_mesh.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// What has been measured of a tile, or of a part of it; parts add up.
struct MeasuredError {
  double max_m = 0;         ///< Largest vertical distance at any vertex of the overlay.
  double border_max_m = 0;  ///< The same along the tile's four sides.
  double sum_of_squares = 0;
  std::uint64_t samples = 0;  ///< Samples that the mesh covers.

  MeasuredError& operator+=(const MeasuredError& other);
  double rms_m() const;
};

/// A decoded tile with its vertices in DEM samples and metres.
struct MeasuredMesh {
  struct Vertex {
    double column;
    double row;
    double height_m;
    std::uint8_t sides;  ///< Bits 0 to 3: lies on the tile's west, north, east, south side.
  };

  MeasuredMesh(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh);

  codec::CellRect cells;  ///< Of the tile, cut to the raster.
  std::vector<Vertex> vertices;
  std::vector<codec::Triangle> triangles;
};

/// Measures meshes against the DEM in double precision, one window of it at a time: the samples, the mesh's
/// vertices, and the crossings of its edges with the grid's rows, columns and diagonals (docs/accuracy.md).
/// Cost: about 3 ns a sample and mesh. Not thread-safe.
class ErrorMeter {
 public:
  explicit ErrorMeter(SurfaceView& view) : view_(&view) {}

  /// Loads the window that the following calls measure in.
  void set_window(const codec::CellRect& window);

  /// The error of those triangles of `mesh` that `which` names, within the window. Each sample counts once
  /// for a tile whose windows tile it.
  MeasuredError measure(const MeasuredMesh& mesh, std::span<const std::uint32_t> which);

 private:
  void paint(const MeasuredMesh& mesh, const codec::Triangle& t);
  void compare(const MeasuredMesh& mesh, MeasuredError& out) const;
  void cross_edge(const MeasuredMesh::Vertex& a, const MeasuredMesh::Vertex& b, bool border, MeasuredError& out) const;
  void check_vertex(const MeasuredMesh::Vertex& v, MeasuredError& out) const;
  /// Height of the surface on a grid line: between window sample (i, j) and the one a step on, at share f.
  double between(std::int64_t i, std::int64_t j, std::int64_t di, std::int64_t dj, double f) const;
  double surface_at(double x, double y) const;

  SurfaceView* view_;
  codec::CellRect window_;
  std::int64_t width_ = 0;
  std::int64_t height_ = 0;
  std::vector<double> surface_;
  std::vector<double> painted_;
};

}  // namespace tintree::simplify
