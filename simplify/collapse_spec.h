#pragma once

#include <cstdint>
#include <string_view>

#include "simplify/half_edge_mesh.h"
#include "simplify/height_lattice.h"

namespace tintree::simplify {

/// How hard to look for collapses.
enum class Effort : std::uint8_t {
  kFast,  ///< Two places for the merged vertex.
  kBest,  ///< Also moves its neighbours where that makes room (CollapseRepair).
};

/// By its name on the command line and in the manifest, "fast" or "best".
inline Effort effort_named(std::string_view name) { return name == "best" ? Effort::kBest : Effort::kFast; }

/// The lattice that vertices lie on and the bound that the mesh has to keep.
struct CollapseSpec {
  /// The line of a border ribbon, which runs through the middle of its mesh: x = 0 or y = 0; absent in a tile.
  /// It has a bound of its own.
  enum class Line { kAbsent, kX, kY };

  double bound_m = 0;  ///< Largest vertical distance to the surface, guard already taken off.
  Line line = Line::kAbsent;
  double line_bound_m = 0;  ///< The same along that line.
  HeightLattice heights;    ///< What z counts.
  int sub_bits = 0;         ///< x and y count 2^-sub_bits samples.
  int coarse_bits = 0;      ///< Vertices that move go to multiples of 2^coarse_bits lattice steps.
  double area_unit = 1;     ///< Area in cells that the quadrics' weights count as one.
  Effort effort = Effort::kFast;

  bool on_line(const LatticeVertex& v) const {
    return (line == Line::kX && v.x == 0) || (line == Line::kY && v.y == 0);
  }
};

}  // namespace tintree::simplify
