#include "simplify/wavelet_maker.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "codec/residual_plane.h"
#include "codec/split_fans.h"
#include "codec/wavelet_tiles.h"
#include "simplify/finish_tile.h"
#include "simplify/neville_rows.h"

namespace tintree::simplify {
namespace {

/// Patches with others below them keep to that part of their bound, which is twice the bound below: most of those then
/// are foretold well enough, or nearly so.
constexpr double kShareAbove = 0.4;

/// The mesh as it is stored.
Expected<codec::TileMesh> stored_mesh(const StartMesh& start, std::int64_t cells, const codec::TileId& id) {
  codec::TileMesh out;
  if (start.triangles.empty()) return out;
  out.z_offset = start.heights.origin;
  out.vertices.reserve(start.vertices.size());
  for (const LatticeVertex& v : start.vertices) out.vertices.push_back({v.x, v.y, v.z});
  out.triangles.reserve(start.triangles.size());
  for (const auto& t : start.triangles) {
    out.triangles.push_back(
        {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
  }
  codec::split_fans(out);
  return finish_tile(std::move(out), cells, 0, id);
}

}  // namespace

WaveletMaker::WaveletMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout,
                           codec::PatchCriterion criterion, const StopFlag* stop)
    : view_(surface, stop), layout_(layout), criterion_(criterion) {}

Expected<codec::TileMesh> WaveletMaker::make(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const LevelGrid level{cells, layout_.bound_m(id.level), {layout_.z_step_m[static_cast<std::size_t>(id.level)]}};
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  RightTriangleMesh mesh(view_, level, std::int64_t{id.x} * cells, std::int64_t{id.y} * cells);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  const StartMesh tile = mesh.tile();
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  return stored_mesh(tile, cells, id);
}

/// The tile's patch of its level's layer, in units of its level.
codec::Patch WaveletMaker::target(const codec::TileId& id) {
  const int n = layout_.tile_cells;
  const int side = n + 2 * codec::kPatchMargin;
  const double unit_m = layout_.z_step_m[static_cast<std::size_t>(id.level)] / codec::kUnitsAStep;
  const SampleRows samples = [this](std::int64_t column, std::int64_t row, std::vector<double>& out) {
    const cache::HeightBlocks& blocks = view_.surface().blocks();
    const bool in_rows = row >= 0 && row < blocks.rows() && !view_.interrupted();
    for (std::size_t i = 0; i < out.size(); ++i, ++column) {
      const bool inside = in_rows && column >= 0 && column < blocks.columns();
      out[i] = inside ? view_.sample(column, row) : std::numeric_limits<double>::quiet_NaN();
    }
  };
  NevilleRows rows(samples, layout_.leaf_level - id.level, std::int64_t{id.x} * n - codec::kPatchMargin,
                   std::int64_t{id.y} * n - codec::kPatchMargin, side);
  codec::Patch out(side, codec::kNoHeight);
  for (int y = 0; y < side; ++y) {
    const std::vector<double>& row = rows.next();
    for (int x = 0; x < side; ++x) {
      const double h = row[static_cast<std::size_t>(x)];
      if (!std::isnan(h)) out.at(x, y) = std::llround(h / unit_m);
    }
  }
  return out;
}

Expected<std::shared_ptr<const codec::EncodedPatch>> WaveletMaker::patch(const codec::TileId& id) {
  if (auto known = patches_.find(id)) return known;
  std::shared_ptr<const codec::EncodedPatch> parent;
  if (id.level > 0) {
    auto above = patch(layout_.parent(id));
    if (!above) return above;
    parent = std::move(*above);
  }
  const double unit_m = layout_.z_step_m[static_cast<std::size_t>(id.level)] / codec::kUnitsAStep;
  codec::PatchSpec spec;
  spec.criterion = criterion_;
  const double share = id.level < layout_.leaf_level ? kShareAbove : 1;
  spec.bound = std::llround(share * layout_.bound_m(id.level) / unit_m);
  spec.quick = true;
  spec.lifted = criterion_ == codec::PatchCriterion::kMax;
  const codec::Patch prediction =
      codec::wavelet_prediction(layout_, id, parent == nullptr ? nullptr : &parent->reconstruction);
  auto coded = codec::encode_patch(target(id), prediction, spec);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  if (!coded) return tl::unexpected(coded.error());
  auto out = std::make_shared<const codec::EncodedPatch>(std::move(*coded));
  patches_.keep(id, out);
  return out;
}

Expected<std::vector<std::byte>> WaveletMaker::encode(const codec::MeshCodec&, const codec::TileId& id,
                                                      const codec::TileMesh& mesh) {
  const auto own = patch(id);
  if (!own) return tl::unexpected(own.error());
  return codec::encode_wavelet_tile(layout_, id, mesh, **own);
}

Expected<TileReader> WaveletMaker::stand_in_above(const codec::TileId& id) {
  patches_ = {};
  const codec::EncodedPatch level{codec::residual_bytes({}, {}), {layout_.tile_cells + 2 * codec::kPatchMargin, 0}};
  if (id.level > 0) {
    const codec::TileId parent = layout_.parent(id);
    if (parent.level > 0) patches_.keep(layout_.parent(parent), std::make_shared<const codec::EncodedPatch>(level));
    if (auto made = patch(parent); !made) return tl::unexpected(made.error());
  }
  return [this, level](const codec::TileId& wanted) -> Expected<cache::StoredTile> {
    cache::StoredTile out;
    out.info.id = wanted;
    const auto known = patches_.find(wanted);
    out.payload = known == nullptr ? level.bytes : known->bytes;
    return out;
  };
}

}  // namespace tintree::simplify
