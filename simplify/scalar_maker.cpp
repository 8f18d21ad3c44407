#include "simplify/scalar_maker.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "simplify/border_places.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

/// Height steps between the levels of a uniform quantiser: what takes the fewest bytes where grids adapt to the ground.
constexpr std::int64_t kStep = 3;
/// The same at most: half of that is under the bound, which is four steps, and under kRowShare of it. Fewer bits a
/// height, but more vertices.
constexpr std::int64_t kCoarsestStep = 7;
/// Where there are more cells, of the tile's, at the former the latter is worth a try.
constexpr double kDenseShare = 0.2;
/// What the least mean square's quantiser may move heights by, of the bound.
constexpr double kLloydMaxShare = 0.5;
/// Enough for a quantiser of which the bound asks more than the least mean square.
constexpr int kLloydMaxIterations = 50;

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
  if (quantizer_ == codec::QuantizerKind::kLloydMax) {
    wanted.bound_m *= 1 - kLloydMaxShare;
    tile.shape = choose_blocks(view_, wanted);
  } else {
    tile.shape = choose_step(wanted, reach_m, range[1] - range[0]);
  }
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
  border_count_ = grid->border_count;
  for (const codec::GridVertex& v : grid->places) {
    const double h = view_.sample(wanted.column0 + v.x, wanted.row0 + v.y);
    samples_m_.push_back(h);
    z_.push_back(std::isnan(h) ? 0 : wanted.address(v.x, v.y, h));
  }
  if (quantizer_ == codec::QuantizerKind::kLloydMax)
    quantize_lloyd_max(wanted, std::min(kLloydMaxShare * wanted.level.bound_m, reach_m));
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  set_heights(tile);
  coarsen(tile, *grid);
  return tile.mesh(std::move(*grid));
}

/// The blocks, and the step of a uniform quantiser, that take fewer bits. Heights span `relief_m`.
codec::ScalarShape ScalarMaker::choose_step(ScalarSpec& spec, double reach_m, double relief_m) {
  const double relief = relief_m / spec.level.heights.step_m;
  const auto widest = static_cast<std::int64_t>(2 * reach_m / spec.level.heights.step_m);
  const auto bits = [&](const codec::ScalarShape& shape) {
    const auto cells = static_cast<double>(codec::cell_count(shape));
    return cells * std::log2(2 + relief / static_cast<double>(spec.height_step));
  };
  spec.height_step = std::clamp<std::int64_t>(widest, 1, kStep);
  codec::ScalarShape shape = choose_blocks(view_, spec);
  const double samples = static_cast<double>(spec.width()) * spec.height();
  if (static_cast<double>(codec::cell_count(shape)) < kDenseShare * samples || view_.interrupted()) return shape;
  const double fine_bits = bits(shape);
  const std::int64_t fine_step = spec.height_step;
  spec.height_step = std::clamp<std::int64_t>(widest, 1, kCoarsestStep);
  codec::ScalarShape coarse = choose_blocks(view_, spec);
  if (bits(coarse) < fine_bits) return coarse;
  spec.height_step = fine_step;
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

/// The fewest levels that move no height by more than `reach_m`, as far as halving finds them.
void ScalarMaker::quantize_lloyd_max(const ScalarSpec& spec, double reach_m) {
  std::vector<std::int64_t> heights;
  for (std::size_t i = border_count_; i < z_.size(); ++i) {
    if (!std::isnan(samples_m_[i])) heights.push_back(z_[i]);
  }
  if (heights.empty()) return;
  std::ranges::sort(heights);
  std::vector<codec::HeightWeight> histogram;
  const std::int64_t lowest = heights.front();
  for (const std::int64_t z : heights) {
    const auto relative = static_cast<double>(z - lowest);
    if (histogram.empty() || histogram.back().height_m != relative) histogram.push_back({relative, 0});
    ++histogram.back().weight;
  }
  std::vector<std::int64_t> best = z_;
  std::size_t too_few = 0;
  std::size_t enough = histogram.size();  // every height its own
  while (enough > too_few + 1 && !view_.interrupted()) {
    const std::size_t levels = (too_few + enough) / 2;
    const codec::Quantizer quantizer = codec::lloyd_max_quantizer(histogram, levels, kLloydMaxIterations).quantizer;
    std::vector<std::int64_t> tried = z_;
    bool fits = true;
    for (std::size_t i = border_count_; i < z_.size() && fits; ++i) {
      if (std::isnan(samples_m_[i])) continue;
      tried[i] = lowest + std::llround(quantizer.value(static_cast<double>(z_[i] - lowest)));
      fits = std::abs(static_cast<double>(tried[i]) * spec.level.heights.step_m - samples_m_[i]) <= reach_m;
    }
    (fits ? enough : too_few) = levels;
    if (fits) best = std::move(tried);
  }
  z_ = std::move(best);
}

}  // namespace tintree::simplify
