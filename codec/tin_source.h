#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// A mesh whose triangles know their neighbours. Half-edge 3 t + k leads from corner k of triangle t to the next one.
class TinSource {
 public:
  static constexpr std::int32_t kNone = -1;

  /// Nothing where the mesh is no 2-manifold, has no triangles, flipped ones or vertices without any, or has a place
  /// that is negative or beyond `most`. The mesh must outlive it.
  static std::optional<TinSource> of(const TileMesh& mesh, std::int32_t most);

  static std::int32_t following(std::int32_t half) { return half % 3 == 2 ? half - 2 : half + 1; }
  const TileMesh& mesh() const { return *mesh_; }
  std::uint32_t origin(std::int32_t half) const {
    return mesh_->triangles[static_cast<std::size_t>(half / 3)][static_cast<std::size_t>(half % 3)];
  }
  /// The other half of its edge, or kNone.
  std::int32_t twin(std::int32_t half) const { return twins_[static_cast<std::size_t>(half)]; }
  std::int32_t half_edges() const { return static_cast<std::int32_t>(twins_.size()); }
  /// The greatest x and y.
  std::int32_t width() const { return width_; }
  std::int32_t height() const { return height_; }

  /// The half-edges along the sides of the rectangle (0, 0) to (width, height) from the origin southward, if these are
  /// an outline of the mesh; else none.
  std::vector<std::int32_t> rectangle() const;

 private:
  bool find_twins();
  bool whole_fans() const;

  const TileMesh* mesh_ = nullptr;
  std::vector<std::int32_t> twins_;
  std::vector<std::uint32_t> first_;   // of each vertex in leaving_
  std::vector<std::int32_t> leaving_;  // half-edges by origin
  std::int32_t width_ = 0;
  std::int32_t height_ = 0;
};

}  // namespace tintree::codec
