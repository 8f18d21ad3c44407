#include "apps/audit/tile_surface.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace tintree::audit {
namespace {

/// One use of an edge by a triangle, filed under its lower vertex.
struct Use {
  std::uint32_t higher;
  bool upward;  ///< The triangle runs it from the lower to the higher vertex.
};

/// All uses of edges, grouped by lower vertex: those of vertex v are [begin[v], begin[v + 1]).
struct Uses {
  std::vector<std::size_t> begin;
  std::vector<Use> list;
};

Uses collect_uses(const TileSurface& s) {
  Uses uses;
  uses.begin.assign(s.corners.size() + 2, 0);
  const auto each = [&s](auto&& visit) {
    for (const codec::Triangle& t : s.triangles) {
      for (std::size_t k = 0; k < 3; ++k) visit(t[k], t[(k + 1) % 3]);
    }
  };
  each([&](std::uint32_t a, std::uint32_t b) { ++uses.begin[std::min(a, b) + 2]; });
  std::partial_sum(uses.begin.begin(), uses.begin.end(), uses.begin.begin());
  uses.list.resize(3 * s.triangles.size());
  each([&](std::uint32_t a, std::uint32_t b) {
    uses.list[uses.begin[std::min(a, b) + 1]++] = {std::max(a, b), a < b};
  });
  return uses;
}

void list_edges(TileSurface& s) {
  Uses uses = collect_uses(s);
  s.edges.reserve(s.triangles.size() * 3 / 2 + 16);
  for (std::uint32_t v = 0; v < s.corners.size(); ++v) {
    const std::span<Use> mine(uses.list.data() + uses.begin[v], uses.begin[v + 1] - uses.begin[v]);
    std::ranges::sort(mine, {}, &Use::higher);
    for (std::size_t i = 0; i < mine.size();) {
      std::size_t end = i + 1;
      while (end < mine.size() && mine[end].higher == mine[i].higher) ++end;
      const bool open = end - i == 1;
      if (end - i > 2 || (end - i == 2 && mine[i].upward == mine[i + 1].upward)) ++s.overused_edges;
      const bool downward = open && !mine[i].upward;
      s.edges.push_back(downward ? Edge{mine[i].higher, v, open} : Edge{v, mine[i].higher, open});
      i = end;
    }
  }
}

}  // namespace

TileSurface place(const codec::TreeLayout& layout, const codec::TileId& id, codec::TileMesh mesh) {
  const codec::GridFrame frame(layout, id, mesh);
  TileSurface s;
  s.cells = layout.cells(id);
  s.across = layout.cells_across(id.level);
  s.units = mesh.xy_shift < 0 ? 1 << -mesh.xy_shift : 1;
  const int shift = std::max(mesh.xy_shift, 0);
  s.corners.reserve(mesh.vertices.size());
  for (const codec::GridVertex& v : mesh.vertices) {
    s.corners.push_back({v.x << shift, v.y << shift, mesh.z_offset + v.z, frame.height_m(v.z)});
  }
  s.triangles = std::move(mesh.triangles);
  list_edges(s);
  return s;
}

}  // namespace tintree::audit
