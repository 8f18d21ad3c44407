#include "simplify/tin_maker.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "codec/coded_tin_mesh.h"
#include "simplify/finish_tile.h"

namespace tintree::simplify {
namespace {

/// Below this bound, in sample spacings, the best effort lets vertices lie on half samples: it pays where triangles
/// are a few samples large (docs/performance.md, What was tried).
constexpr double kFineLattice = 0.25;

/// Moving vertices keep to a lattice at least this much finer than the distance between the vertices that will be left
/// (docs/performance.md, What was tried).
constexpr double kStepsPerSpacing = 6;
/// About how many vertices of a start mesh end in one.
constexpr double kStartVertices = 4;

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Twice the mesh's area in lattice steps squared.
double doubled_area(const HalfEdgeMesh& mesh) {
  std::int64_t sum = 0;
  for (std::int32_t h = 0; h < mesh.half_edge_count(); h += 3) {
    if (!mesh.triangle_alive(h)) continue;
    const LatticeVertex& a = mesh.vertex(mesh.origin(h));
    const LatticeVertex& b = mesh.vertex(mesh.origin(h + 1));
    const LatticeVertex& c = mesh.vertex(mesh.origin(h + 2));
    sum += std::int64_t{c.x - a.x} * (b.y - a.y) - std::int64_t{b.x - a.x} * (c.y - a.y);
  }
  return static_cast<double>(sum);
}

/// The coarsest lattice that loses hardly anything over a start mesh, in binary digits over the mesh's own. None where
/// a vertex that has to stay, on a border or at a hole, lies off it: then the tile could not be stored on it.
int coarsest_lattice(const HalfEdgeMesh& mesh) {
  std::int64_t live = 0;
  std::uint32_t fixed = 1U << codec::kMaxXyShift;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.alive(v)) continue;
    ++live;
    const LatticeVertex& p = mesh.vertices[at(v)];
    if (mesh.kinds[at(v)] >= VertexKind::kPinned) fixed |= static_cast<std::uint32_t>(p.x | p.y);
  }
  const double spacing = std::sqrt(kStartVertices * doubled_area(mesh) / 2 / static_cast<double>(live));
  const int wanted = live == 0 ? 0 : static_cast<int>(std::floor(std::log2(spacing / kStepsPerSpacing)));
  return std::clamp(wanted, 0, std::countr_zero(fixed));
}

}  // namespace

TinMaker::TinMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                   const StopFlag* stop)
    : view_(surface, stop), layout_(layout), effort_(effort) {}

Expected<codec::TileMesh> TinMaker::make(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const std::int64_t column0 = std::int64_t{id.x} * cells;
  const std::int64_t row0 = std::int64_t{id.y} * cells;
  const LevelGrid level{cells, layout_.bound_m(id.level), {layout_.z_step_m[static_cast<std::size_t>(id.level)]}};
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};

  RightTriangleMesh start(view_, level, column0, row0);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  StartMesh tile = start.tile();
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  mesh_.build(std::move(tile.vertices), tile.triangles);
  heights_ = tile.heights;
  for (const bool southward : {false, true}) {
    for (const std::int64_t offset : {std::int64_t{0}, cells}) {
      settle_side(start, southward ? Side{offset, 0, cells, true} : Side{0, offset, cells, false}, level, id);
    }
  }
  const bool fine = level.bound_m <= kFineLattice * std::sqrt(layout_.dx_m * layout_.dy_m);
  const int sub_bits = effort_ == Effort::kBest && fine ? 1 : 0;
  refine_lattice(sub_bits);
  classify(cells << sub_bits);

  CollapseSpec spec;
  spec.bound_m = tested_bound_m(view_.surface(), layout_.cells(id), level.bound_m);
  spec.heights = heights_;
  spec.sub_bits = sub_bits;
  spec.coarse_bits = coarsest_lattice(mesh_);
  spec.effort = effort_;
  const double scale = level.bound_m / layout_.leaf_error_m;
  spec.area_unit = scale * scale;
  SurfaceDistance distance(view_, column0, row0);
  collapse_.run(mesh_, distance, spec);
  if (view_.error()) return tl::unexpected(*view_.error());
  return take_mesh(id, sub_bits);
}

Expected<std::vector<std::byte>> TinMaker::encode(const codec::MeshCodec& codec, const codec::TileId& /*id*/,
                                                  const codec::TileMesh& mesh) {
  return effort_ == Effort::kBest ? codec::CodedTinMesh().encode(mesh) : codec.encode(mesh);
}

/// From whole samples to 2^-sub_bits of them.
void TinMaker::refine_lattice(int sub_bits) {
  for (LatticeVertex& v : mesh_.vertices) {
    v.x <<= sub_bits;
    v.y <<= sub_bits;
  }
}

/// Repeats what has settled a side in this tile's half of the ribbon. `side` is relative to the tile.
void TinMaker::settle_side(RightTriangleMesh& start, const Side& side, const LevelGrid& level,
                           const codec::TileId& id) {
  std::vector<std::int32_t> vertex_at(static_cast<std::size_t>(side.cells) + 1, kNone);
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    const LatticeVertex& p = mesh_.vertices[at(v)];
    std::int32_t& slot = vertex_at[at(side.along(p))];
    if (mesh_.alive(v) && side.across(p) == (side.southward ? side.column : side.row) && slot == kNone) slot = v;
  }
  const Side in_dem{side.column + std::int64_t{id.x} * side.cells, side.row + std::int64_t{id.y} * side.cells,
                    side.cells, side.southward};
  const RibbonPlan plan = ribbon_.settle(view_, start, in_dem, level);
  // A plan that was cut short may be made for a part of the band.
  if (view_.interrupted()) return;
  for (const RibbonFlip& flip : plan.flips) {
    const std::int32_t near = vertex_at[at(flip.index)];
    if (near != kNone) repeat(flip, near, side);
  }
  for (const RibbonStep& step : plan.steps) {
    const std::int32_t gone = vertex_at[at(step.index)];
    if (gone != kNone && mesh_.alive(gone)) repeat(step, gone, side);
  }
}

/// Flips the edge of `near` that leads there; on one side of the line alone there is one.
void TinMaker::repeat(const RibbonFlip& flip, std::int32_t near, const Side& side) {
  const std::int32_t start = mesh_.outgoing(near);
  for (std::int32_t h = start; h != kNone;) {
    const LatticeVertex& far = mesh_.vertex(mesh_.target(h));
    if (far.x - side.column == flip.far.x && far.y - side.row == flip.far.y) return mesh_.flip(h);
    const std::int32_t following = mesh_.rotate(h);
    h = following == start ? kNone : following;
  }
}

void TinMaker::repeat(const RibbonStep& step, std::int32_t gone, const Side& side) {
  // The neighbour along the side is one end of the fan of triangles on this side of the line.
  const std::int32_t first = mesh_.outgoing(gone);
  const std::int32_t last = mesh_.last_outgoing(gone);
  for (const std::int32_t h : {first, HalfEdgeMesh::previous(last)}) {
    const std::int32_t kept = h == first ? mesh_.target(h) : mesh_.origin(h);
    const LatticeVertex& from = mesh_.vertices[at(gone)];
    LatticeVertex& to = mesh_.vertices[at(kept)];
    const bool ahead = side.along(to) > side.along(from);
    if (side.across(to) != side.across(from) || ahead != (step.towards > 0)) continue;
    to.z = static_cast<std::int32_t>(step.z - heights_.origin);
    mesh_.collapse(h, kept);
    return;
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

/// The live part of the mesh.
Expected<codec::TileMesh> TinMaker::take_mesh(const codec::TileId& id, int sub_bits) const {
  codec::TileMesh out;
  out.z_offset = heights_.origin;
  std::vector<std::int32_t> compact(mesh_.vertices.size(), kNone);
  for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (!mesh_.alive(v)) continue;
    const LatticeVertex& p = mesh_.vertices[at(v)];
    compact[at(v)] = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.push_back({p.x, p.y, p.z});
  }
  for (std::int32_t h = 0; h < mesh_.half_edge_count(); h += 3) {
    if (!mesh_.triangle_alive(h)) continue;
    const auto corner = [&](std::int32_t k) { return static_cast<std::uint32_t>(compact[at(mesh_.origin(h + k))]); };
    out.triangles.push_back({corner(0), corner(1), corner(2)});
  }
  return finish_tile(std::move(out), layout_.cells_across(id.level) << sub_bits, sub_bits, id);
}

}  // namespace tintree::simplify
