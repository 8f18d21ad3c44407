#include "simplify/tin_maker.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace tintree::simplify {
namespace {

/// Vertices lie on fractions of samples: 2^-kSubBits (docs/performance.md, Lattice).
constexpr int kSubBits = 0;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

TinMaker::TinMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, const StopFlag* stop)
    : view_(surface, stop), layout_(layout) {}

Expected<codec::TileMesh> TinMaker::make(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const std::int64_t column0 = std::int64_t{id.x} * cells;
  const std::int64_t row0 = std::int64_t{id.y} * cells;
  const HeightLattice heights{layout_.z_step_m[static_cast<std::size_t>(id.level)]};
  const double bound = layout_.bound_m(id.level);
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  const double tested = tested_bound_m(view_.surface(), layout_.cells(id), bound);

  SurfaceDistance distance(view_, column0, row0);
  const std::int64_t last = cells - 1;
  const CornerFlips flips{may_flip(view_, column0 + last, row0, bound, heights),
                          may_flip(view_, column0, row0 + last, bound, heights)};
  StartMesh start = right_triangle_mesh(distance, view_, column0, row0, cells, tested, heights, flips);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  for (LatticeVertex& v : start.vertices) {
    v.x <<= kSubBits;
    v.y <<= kSubBits;
  }
  mesh_.build(std::move(start.vertices), start.triangles);
  settle_side(start, 0, {column0, row0, cells, false}, bound, heights);
  settle_side(start, 1, {column0, row0 + cells, cells, false}, bound, heights);
  settle_side(start, 2, {column0, row0, cells, true}, bound, heights);
  settle_side(start, 3, {column0 + cells, row0, cells, true}, bound, heights);
  classify(cells << kSubBits);

  CollapseSpec spec;
  spec.bound_m = tested;
  spec.z_step_m = heights.step_m;
  spec.sub_bits = kSubBits;
  const double scale = static_cast<double>(cells) / layout_.tile_cells;
  spec.area_unit = scale * scale;
  collapse_.run(mesh_, distance, spec);
  if (view_.error()) return tl::unexpected(*view_.error());
  return take_mesh(id);
}

/// Repeats the side's settled collapses in this tile's half of the ribbon.
void TinMaker::settle_side(const StartMesh& start, std::size_t which, const Side& side, double bound_m,
                           const HeightLattice& heights) {
  for (const RibbonStep& step : ribbon_.settle(view_, side, bound_m, heights)) {
    const std::int32_t gone = start.sides[which][at(step.index)];
    if (gone == kNone || !mesh_.alive(gone)) continue;
    // The neighbour along the side is one end of the fan of triangles on this side of the line.
    const std::int32_t first = mesh_.outgoing(gone);
    const std::int32_t last = mesh_.last_outgoing(gone);
    for (const std::int32_t h : {first, HalfEdgeMesh::previous(last)}) {
      const std::int32_t kept = h == first ? mesh_.target(h) : mesh_.origin(h);
      const LatticeVertex& from = mesh_.vertices[at(gone)];
      LatticeVertex& to = mesh_.vertices[at(kept)];
      const std::int32_t ahead = side.southward ? to.y - from.y : to.x - from.x;
      const bool same_line = side.southward ? to.x == from.x : to.y == from.y;
      if (!same_line || (ahead > 0) != (step.towards > 0)) continue;
      to.z = step.z;
      mesh_.collapse(h, kept);
      break;
    }
  }
}

void TinMaker::classify(std::int64_t span) {
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (!mesh_.alive(v) || !mesh_.on_outline(v)) continue;
    const LatticeVertex& here = mesh_.vertices[at(v)];
    VertexKind& kind = mesh_.kinds[at(v)];
    if (here.x == 0 || here.y == 0 || here.x == span || here.y == span) {
      kind = VertexKind::kLocked;
      continue;
    }
    const std::int32_t first = mesh_.outgoing(v);
    const std::int32_t last = mesh_.last_outgoing(v);
    const LatticeVertex& a = mesh_.vertices[at(mesh_.target(first))];
    const LatticeVertex& b = mesh_.vertices[at(mesh_.origin(HalfEdgeMesh::previous(last)))];
    const std::int64_t turn = std::int64_t{a.x - here.x} * (b.y - here.y) - std::int64_t{a.y - here.y} * (b.x - here.x);
    const std::int64_t along =
        std::int64_t{a.x - here.x} * (b.x - here.x) + std::int64_t{a.y - here.y} * (b.y - here.y);
    kind = turn == 0 && along < 0 ? VertexKind::kSlide : VertexKind::kPinned;
  }
}

/// The live part of the mesh, on the coarsest address grid that holds it.
Expected<codec::TileMesh> TinMaker::take_mesh(const codec::TileId& id) const {
  codec::TileMesh out;
  std::vector<std::int32_t> compact(mesh_.vertices.size(), kNone);
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  std::uint32_t all_bits = static_cast<std::uint32_t>(layout_.cells_across(id.level) << kSubBits);
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (!mesh_.alive(v)) continue;
    const LatticeVertex& p = mesh_.vertices[at(v)];
    compact[at(v)] = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.push_back({p.x, p.y, p.z});
    lowest = std::min(lowest, p.z);
    highest = std::max(highest, p.z);
    all_bits |= static_cast<std::uint32_t>(p.x) | static_cast<std::uint32_t>(p.y);
  }
  if (out.vertices.empty()) return out;
  if (highest - lowest > codec::kMaxHeightAddress) {
    return fail(ErrorCode::kBadData,
                fmt::format("its relief spans {} height steps, more than the {} of the format; choose an --error at "
                            "least {:.1f} times as large",
                            highest - lowest, codec::kMaxHeightAddress,
                            static_cast<double>(highest - lowest) / codec::kMaxHeightAddress),
                "tile " + id.text());
  }
  const int shift = std::countr_zero(all_bits);
  out.xy_shift = shift - kSubBits;
  out.z_offset = lowest;
  for (codec::GridVertex& v : out.vertices) v = {v.x >> shift, v.y >> shift, v.z - lowest};
  for (std::int32_t h = 0; h < mesh_.half_edge_count(); h += 3) {
    if (!mesh_.triangle_alive(h)) continue;
    const auto corner = [&](std::int32_t k) { return static_cast<std::uint32_t>(compact[at(mesh_.origin(h + k))]); };
    out.triangles.push_back({corner(0), corner(1), corner(2)});
  }
  return out;
}

}  // namespace tintree::simplify
