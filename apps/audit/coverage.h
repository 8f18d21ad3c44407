#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "apps/audit/height_window.h"
#include "apps/audit/tile_surface.h"

namespace tintree::audit {

/// Places at which something is wrong: how many, and the first.
struct Faults {
  std::uint64_t count = 0;
  std::string first;

  void add(const std::string& what) {
    if (count++ == 0) first = what;
  }
  void add(const Faults& other) {
    if (count == 0) first = other.first;
    count += other.count;
  }
};

/// Proves that the mesh covers every reference triangle of its tile exactly once and nothing else.
///
/// The number of mesh triangles over a point is a 2-chain in the plane, and such a chain is determined by
/// its boundary. All mesh triangles turn the same way (validate() checks that), so it suffices that the
/// mesh's open edges, taken with direction, are exactly the outline of the union of the existing
/// reference triangles: every unit edge of the outline is run once over its whole length in the right
/// direction, and no open edge lies anywhere else. All of it is decided in whole numbers.
///
/// This class checks the outline within one window; place_open_edges() has to find no fault either.
/// Cost: about 3 ns a cell.
class Coverage {
 public:
  struct Result {
    Faults faults;
    std::uint64_t reference_triangles = 0;  ///< Existing ones of the window's cells.
  };

  /// `edges`: those that may touch the window.
  Result check(const TileSurface& surface, const HeightWindow& window, std::span<const std::uint32_t> edges);

 private:
  /// A stretch of one unit edge of the grid that an open mesh edge runs along.
  struct Run {
    std::uint64_t edge;  // see edge_number()
    std::int32_t from;   // lattice units from the unit edge's north-west end
    std::int32_t to;
    bool forward;  // away from the north-west end
  };
  struct Outline {
    std::uint64_t edge;
    bool forward;
  };
  /// An open mesh edge on a grid line, seen from its north-west end.
  struct OpenEdge {
    std::uint32_t kind = 0;   // row, column or diagonal
    bool forward = true;      // run away from that end
    std::int64_t column = 0;  // sample at or before the end
    std::int64_t row = 0;
    std::int64_t lead = 0;  // lattice units from that sample to the end
    std::int64_t length = 0;
  };

  void add_runs(const HeightWindow& window, const OpenEdge& edge, int units);
  void list_runs(const TileSurface& surface, const HeightWindow& window, std::span<const std::uint32_t> edges);
  std::uint64_t list_outline(const HeightWindow& window);
  Faults compare(const HeightWindow& window, int units) const;

  std::vector<Run> runs_;
  std::vector<Outline> outline_;
  std::vector<std::uint8_t> above_;
  std::vector<std::uint8_t> here_;
};

/// Open edges must run along rows, columns or diagonals of the grid: the rest lies inside the surface.
Faults place_open_edges(const TileSurface& surface);

/// Twice the area of the mesh in lattice units squared; exact.
std::int64_t doubled_area(const TileSurface& surface);

}  // namespace tintree::audit
