#include "simplify/scalar_maker.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "simplify/border_places.h"
#include "simplify/scalar_levels.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

/// Height steps between the levels of a uniform quantiser, and twice and one more than a Lloyd-Max one moves heights
/// by: what takes the fewest bytes where grids adapt to the ground.
constexpr std::int64_t kStep = 3;
/// The same at most: half of that is under the bound, which is four steps, and under kRowShare of it. Fewer bits a
/// height, but more vertices.
constexpr std::int64_t kCoarsestStep = 7;
/// Where there are more cells, of the tile's, at the former the latter is worth a try.
constexpr double kDenseShare = 0.2;
/// Bits of an entry in a table of levels, about.
constexpr double kEntryBits = 8;

/// On the coarsest address grid that holds it.
void coarsen(codec::ScalarTile& tile, codec::ScalarGrid& grid) {
  codec::BlockTree& blocks = tile.shape.blocks;
  auto bits = static_cast<std::uint32_t>(blocks.width() | blocks.height());
  for (const codec::GridVertex& place : grid.places) bits |= static_cast<std::uint32_t>(place.x | place.y);
  blocks.for_each([&](const codec::GridBlock& block) { bits |= static_cast<std::uint32_t>(block.stride); });
  tile.xy_shift = std::countr_zero(bits);
  blocks.coarsen(tile.xy_shift);
  for (auto& places : tile.shape.sides) {
    for (std::int32_t& at : places) at >>= tile.xy_shift;
  }
  for (codec::GridVertex& place : grid.places) place = {place.x >> tile.xy_shift, place.y >> tile.xy_shift, 0};
}

}  // namespace

ScalarMaker::ScalarMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout,
                         codec::QuantizerKind quantizer, const StopFlag* stop)
    : view_(surface, stop), layout_(layout), quantizer_(quantizer) {}

Expected<codec::TileMesh> ScalarMaker::make(const codec::TileId& id) {
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  ScalarSpec wanted = spec(id);
  const double reach_m = std::min(wanted.bound_m, kRowShare * wanted.level.bound_m);
  codec::ScalarTile tile;
  tile.shape = choose_quantizer(wanted, reach_m, range[1] - range[0]);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  auto grid = codec::make_scalar_grid(tile.shape);
  if (!grid) {
    return fail(ErrorCode::kBadData,
                fmt::format("within the bound it takes grids of more than the {} vertices of method scalar; choose a "
                            "larger --error, or --method tin",
                            codec::kMaxGridVertices),
                "tile " + id.text());
  }
  samples_m_.clear();
  z_.clear();
  for (const codec::GridVertex& v : grid->places) {
    const double h = view_.sample(wanted.column0 + v.x, wanted.row0 + v.y);
    samples_m_.push_back(h);
    z_.push_back(std::isnan(h) ? 0 : wanted.address(v.x, v.y, h));
  }
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  set_heights(tile);
  coarsen(tile, *grid);
  return tile.mesh(std::move(*grid));
}

/// The blocks, and the quantiser of `spec`, that take fewer bits. Heights span `relief_m`.
codec::ScalarShape ScalarMaker::choose_quantizer(ScalarSpec& spec, double reach_m, double relief_m) {
  HeightHistogram histogram;
  if (quantizer_ == codec::QuantizerKind::kLloydMax) histogram = height_histogram(view_, spec);
  const auto widest = static_cast<std::int64_t>(2 * reach_m / spec.level.heights.step_m);
  const auto set_step = [&](std::int64_t wished) {
    spec.height_step = std::clamp<std::int64_t>(widest, 1, wished);
    spec.levels = lloyd_max_levels(histogram, (spec.height_step - 1) / 2);
  };
  const auto bits = [&](const codec::ScalarShape& shape) {
    const auto listed = static_cast<double>(spec.levels.size());
    const double levels =
        listed > 0 ? 1 + listed : 2 + relief_m / spec.level.heights.step_m / static_cast<double>(spec.height_step);
    return static_cast<double>(codec::cell_count(shape)) * std::log2(levels) + listed * kEntryBits;
  };
  set_step(kStep);
  codec::ScalarShape shape = choose_blocks(view_, spec);
  const double samples = static_cast<double>(spec.width()) * spec.height();
  if (static_cast<double>(codec::cell_count(shape)) < kDenseShare * samples || view_.interrupted()) return shape;
  const double fine_bits = bits(shape);
  ScalarSpec fine = spec;
  set_step(kCoarsestStep);
  codec::ScalarShape coarse = choose_blocks(view_, spec);
  if (bits(coarse) < fine_bits) return coarse;
  spec = std::move(fine);
  return shape;
}

void ScalarMaker::set_heights(codec::ScalarTile& tile) const {
  tile.z_offset = std::numeric_limits<std::int64_t>::max();
  bool missing = false;
  for (std::size_t i = 0; i < z_.size(); ++i) {
    tile.missing.push_back(std::isnan(samples_m_[i]));
    missing = missing || tile.missing[i];
    if (!tile.missing[i]) tile.z_offset = std::min(tile.z_offset, z_[i]);
  }
  for (std::size_t i = 0; i < z_.size(); ++i) {
    tile.z.push_back(tile.missing[i] ? 0 : static_cast<std::int32_t>(z_[i] - tile.z_offset));
  }
  if (!missing) tile.missing.clear();
}

ScalarSpec ScalarMaker::spec(const codec::TileId& id) {
  using Shape = codec::ScalarShape;
  const std::int64_t cells = layout_.cells_across(id.level);
  const codec::CellRect rect = layout_.cells(id);
  ScalarSpec out;
  out.level = {cells, layout_.bound_m(id.level), {layout_.z_step_m[static_cast<std::size_t>(id.level)]}};
  out.column0 = rect.column0;
  out.row0 = rect.row0;
  out.bound_m = tested_bound_m(view_.surface(), rect, out.level.bound_m);
  out.sides[Shape::kNorth] = border_places(view_, out.level, {rect.column0, rect.row0, cells, false});
  out.sides[Shape::kSouth] = border_places(view_, out.level, {rect.column0, rect.row1, cells, false});
  out.sides[Shape::kWest] = border_places(view_, out.level, {rect.column0, rect.row0, cells, true});
  out.sides[Shape::kEast] = border_places(view_, out.level, {rect.column1, rect.row0, cells, true});
  return out;
}

}  // namespace tintree::simplify
