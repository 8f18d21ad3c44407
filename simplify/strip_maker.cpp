#include "simplify/strip_maker.h"

#include "codec/coded_strip_mesh.h"
#include "simplify/restricted_quadtree.h"

namespace tintree::simplify {
namespace {

/// Heights are multiples of so many of the level's steps, of which four make the bound.
constexpr int kHeightUnit = 2;

}  // namespace

StripMaker::StripMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                       const StopFlag* stop)
    : view_(surface, stop), layout_(layout), effort_(effort) {}

Expected<codec::TileMesh> StripMaker::make(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const std::int64_t column0 = std::int64_t{id.x} * cells;
  const std::int64_t row0 = std::int64_t{id.y} * cells;
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  const double step_m = layout_.z_step_m[static_cast<std::size_t>(id.level)];
  const LevelGrid level{cells, layout_.bound_m(id.level), {kHeightUnit * step_m}};
  const RestrictedQuadtree tree(view_, level, column0, row0);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  auto mesh = quadtree_tile(tree, view_, level.heights, kHeightUnit, column0, row0, id);
  if (view_.error()) return tl::unexpected(*view_.error());
  return mesh;
}

Expected<std::vector<std::byte>> StripMaker::encode(const codec::MeshCodec& codec, const codec::TileId& /*id*/,
                                                    const codec::TileMesh& mesh) {
  return effort_ == Effort::kBest ? codec::CodedStripMesh().encode(mesh) : codec.encode(mesh);
}

}  // namespace tintree::simplify
