#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/error.h"
#include "codec/sparse_grid.h"
#include "codec/strip_payload.h"
#include "codec/tile_mesh.h"

namespace tintree::codec {

/// Follows a strip triangle by triangle, over payloads that may be damaged, and makes it a mesh again. Vertices of the
/// path are counted as its entries are: 0 and 1 are those of the first entering edge, i + 2 the third of triangle i.
class StripFollower {
 public:
  /// `first` tells where the path begins.
  StripFollower(const StripHead& head, const StripHeader& first);

  /// Where the path stands, before a triangle that winds as `left` says.
  StripHeader header(bool left) const;
  /// The edge that it enters the next triangle by.
  const StripEdge& edge() const { return edge_; }
  /// Entries of that edge's vertices.
  const std::array<std::uint32_t, 2>& entering() const { return entering_; }
  /// Goes on through a triangle; false when that leaves the square, or the begin did.
  bool step(StripType type, bool left);

  /// Number of an entry's vertex, from 0, by their first entries.
  std::size_t vertex(std::size_t entry) const { return static_cast<std::size_t>(places_[entry].vertex); }
  /// Corners of triangle i, as entries.
  const std::array<std::uint32_t, 3>& corners(std::size_t i) const { return corners_[i]; }

  /// The mesh, with the height of every entry as it is coded. Fails where two heights of one vertex differ.
  Expected<TileMesh> mesh(std::span<const std::uint32_t> heights) const;

 private:
  struct Place {
    std::int32_t x, y;
    std::int32_t vertex;
  };
  bool add(std::int32_t x, std::int32_t y);
  bool add_other_end(const Place& from, int sign);

  StripHead head_;
  std::int32_t span_;
  PointNumbers numbers_;
  std::int32_t vertices_ = 0;
  std::vector<Place> places_;
  std::vector<std::array<std::uint32_t, 3>> corners_;
  StripEdge edge_;
  std::array<std::uint32_t, 2> entering_{0, 1};
  bool inside_ = true;
};

}  // namespace tintree::codec
