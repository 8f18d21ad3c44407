#include "simplify/scalar_maker.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "simplify/border_places.h"
#include "simplify/spoke_distance.h"

namespace tintree::simplify {
namespace {

/// Height steps between the levels of a uniform quantiser at most: half of that is under the bound, which is four
/// steps, and under kRowShare of it.
constexpr std::int64_t kCoarsestStep = 7;
/// Enough for a quantiser of which the bound asks more than the least mean square.
constexpr int kLloydMaxIterations = 50;

}  // namespace

ScalarMaker::ScalarMaker(const ReferenceSurface& surface, const codec::TreeLayout& layout,
                         codec::QuantizerKind quantizer, const StopFlag* stop)
    : view_(surface, stop), layout_(layout), quantizer_(quantizer) {}

Expected<codec::TileMesh> ScalarMaker::make(const codec::TileId& id) {
  const auto range = view_.surface().height_range_m(layout_.cells(id));
  if (range[0] > range[1]) return codec::TileMesh{};
  begin(id);
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  if (auto chosen = choose_stride(id); !chosen) return tl::unexpected(chosen.error());
  if (grid_.inner_count() > 0) {
    if (quantizer_ == codec::QuantizerKind::kLloydMax)
      choose_lloyd_max();
    else
      choose_uniform();
  }
  if (view_.interrupted()) return tl::unexpected(*view_.error());
  return take_mesh();
}

void ScalarMaker::begin(const codec::TileId& id) {
  const std::int64_t cells = layout_.cells_across(id.level);
  const codec::CellRect rect = layout_.cells(id);
  column0_ = rect.column0;
  row0_ = rect.row0;
  level_ = {cells, layout_.bound_m(id.level), {layout_.z_step_m[static_cast<std::size_t>(id.level)]}};
  bound_m_ = tested_bound_m(view_.surface(), rect, level_.bound_m);
  distance_.emplace(view_, column0_, row0_);
  grid_ = {};
  grid_.width = static_cast<std::int32_t>(rect.column1 - rect.column0);
  grid_.height = static_cast<std::int32_t>(rect.row1 - rect.row0);
  grid_.sides[codec::ScalarGrid::kNorth] = border_places(view_, level_, {column0_, row0_, cells, false});
  grid_.sides[codec::ScalarGrid::kSouth] = border_places(view_, level_, {column0_, rect.row1, cells, false});
  grid_.sides[codec::ScalarGrid::kWest] = border_places(view_, level_, {column0_, row0_, cells, true});
  grid_.sides[codec::ScalarGrid::kEast] = border_places(view_, level_, {rect.column1, row0_, cells, true});
}

/// Whether a sample of the tile is missing.
bool ScalarMaker::has_hole() {
  const SurfaceWindow& window = distance_->surface();
  for (std::int64_t y = 0; y <= grid_.height;) {
    std::int64_t rows = 0;
    for (std::int64_t x = 0; x <= grid_.width;) {
      const SampleRun run = window.run_at(x, y);
      const std::int64_t columns = std::min(grid_.width - x + 1, run.columns);
      rows = std::min(grid_.height - y + 1, run.rows);
      for (std::int64_t j = 0; j < rows && !run.all_valid; ++j) {
        const float* row = run.heights + j * cache::kBlockStride;
        if (std::any_of(row, row + columns, [](float h) { return std::isnan(h); })) return true;
      }
      x += columns;
    }
    y += rows;
  }
  return false;
}

/// The coarsest stride that fits with heights on the level's lattice; 1 always does.
Expected<void> ScalarMaker::choose_stride(const codec::TileId& id) {
  const std::int64_t shorter = std::min(grid_.width, grid_.height);
  std::int64_t stride = level_.cells / 2;
  while (stride > 1 && stride >= shorter) stride /= 2;
  if (stride > 1 && has_hole()) stride = 1;
  for (;; stride /= 2) {
    if (auto taken = take_samples(id, stride); !taken) return taken;
    quantize(1);
    if (stride == 1 || view_.interrupted() || fits()) return {};
  }
}

Expected<void> ScalarMaker::take_samples(const codec::TileId& id, std::int64_t stride) {
  grid_.stride = static_cast<std::int32_t>(stride);
  const auto count = static_cast<std::int64_t>(grid_.vertex_count());
  if (count > codec::kMaxGridVertices) {
    return fail(
        ErrorCode::kBadData,
        fmt::format("within the bound it takes a grid of {} vertices, more than the {} of method scalar; choose a "
                    "larger --error, --nodata fill where samples are missing, or --method tin",
                    count, codec::kMaxGridVertices),
        "tile " + id.text());
  }
  places_ = grid_.places();
  samples_m_.clear();
  for (const codec::GridVertex& v : places_) samples_m_.push_back(view_.sample(column0_ + v.x, row0_ + v.y));
  return {};
}

/// Inner heights go to the nearest multiples of `step` height steps, those on the sides to the nearest step.
void ScalarMaker::quantize(std::int64_t step) {
  const std::size_t inner = grid_.border_count();
  const HeightLattice coarse{level_.heights.step_m * static_cast<double>(step)};
  z_.resize(samples_m_.size());
  for (std::size_t i = 0; i < samples_m_.size(); ++i) {
    const double h = samples_m_[i];
    z_[i] = std::isnan(h) ? 0 : i < inner ? level_.heights.address(h) : step * coarse.address(h);
  }
}

void ScalarMaker::choose_uniform() {
  for (std::int64_t step = kCoarsestStep; step > 1 && !view_.interrupted(); --step) {
    quantize(step);
    if (fits()) return;
  }
  quantize(1);
}

/// The fewest levels that fit, as far as halving finds them.
void ScalarMaker::choose_lloyd_max() {
  quantize(1);
  std::vector<std::int64_t> heights;
  for (std::size_t i = grid_.border_count(); i < z_.size(); ++i) {
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
  std::size_t too_few = 1;
  std::size_t enough = histogram.size();  // every height its own
  while (enough > too_few + 1 && !view_.interrupted()) {
    const std::size_t levels = (too_few + enough) / 2;
    (quantize_lloyd_max(histogram, lowest, levels) ? enough : too_few) = levels;
  }
  if (enough < histogram.size())
    quantize_lloyd_max(histogram, lowest, enough);
  else
    quantize(1);
}

/// Inner heights go to the nearest of `levels` levels, in steps above `lowest`. Returns whether that fits.
bool ScalarMaker::quantize_lloyd_max(const std::vector<codec::HeightWeight>& histogram, std::int64_t lowest,
                                     std::size_t levels) {
  const codec::Quantizer quantizer = codec::lloyd_max_quantizer(histogram, levels, kLloydMaxIterations).quantizer;
  for (std::size_t i = grid_.border_count(); i < z_.size(); ++i) {
    const double h = samples_m_[i];
    if (!std::isnan(h)) {
      z_[i] = lowest + std::llround(quantizer.value(static_cast<double>(level_.heights.address(h) - lowest)));
    }
  }
  return fits();
}

bool ScalarMaker::fits() {
  if (!vertices_fit()) return false;
  // Between neighbouring samples the surface is as near as at them, and the strip holds for whatever heights are.
  return grid_.stride == 1 || (cells_fit() && strip_fits());
}

bool ScalarMaker::vertices_fit() const {
  const double bound_m = std::min(bound_m_, kRowShare * level_.bound_m);
  for (std::size_t i = grid_.border_count(); i < z_.size(); ++i) {
    const double gap = static_cast<double>(z_[i]) * level_.heights.step_m - samples_m_[i];
    if (std::abs(gap) > bound_m) return false;
  }
  return true;
}

Point ScalarMaker::point(std::size_t vertex) const {
  const codec::GridVertex& v = places_[vertex];
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(z_[vertex]) * level_.heights.step_m};
}

bool ScalarMaker::cells_fit() {
  const auto columns = static_cast<std::size_t>(grid_.columns());
  const auto rows = static_cast<std::size_t>(grid_.rows());
  const std::size_t first = grid_.border_count();
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    if (view_.interrupted()) return false;
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const std::size_t nw = first + row * columns + column;
      const Point a = point(nw);
      const Point d = point(nw + columns + 1);
      const auto fit = [&](const Point& b, const Point& c) {
        return distance_->fit_triangle(a, b, c, bound_m_) == SurfaceDistance::Fit::kWithin;
      };
      if (!fit(d, point(nw + 1)) || !fit(point(nw + columns), d)) return false;
    }
  }
  return true;
}

bool ScalarMaker::strip_fits() {
  Star star;
  star.bound_m = bound_m_;
  for (const codec::Triangle& t : grid_.strip()) {
    if (view_.interrupted()) return false;
    const std::array corners{point(t[0]), point(t[1]), point(t[2])};
    HeightInterval interval;
    star.hub = corners[0];
    star.sides.assign({{corners[1], corners[2]}});
    distance_->clip_star(star, interval);
    for (std::size_t k = 0; k < 3 && !interval.empty(); ++k) {
      // An edge inside the strip is met again, the other way round; the others are the sides' and the cells'.
      if (t[k] > t[(k + 1) % 3]) continue;
      clip_spoke(distance_->surface(), corners[k], corners[(k + 1) % 3], bound_m_, interval);
    }
    if (interval.empty()) return false;
  }
  return true;
}

/// On the coarsest address grid that holds it.
codec::TileMesh ScalarMaker::take_mesh() const {
  codec::ScalarTile tile;
  tile.grid = grid_;
  auto bits = static_cast<std::uint32_t>(grid_.width | grid_.height);
  if (grid_.inner_count() > 0) bits |= static_cast<std::uint32_t>(grid_.stride);
  for (const auto& places : grid_.sides) {
    for (const std::int32_t at : places) bits |= static_cast<std::uint32_t>(at);
  }
  tile.xy_shift = std::countr_zero(bits);
  tile.grid.width >>= tile.xy_shift;
  tile.grid.height >>= tile.xy_shift;
  tile.grid.stride = std::max(1, tile.grid.stride >> tile.xy_shift);
  for (auto& places : tile.grid.sides) {
    for (std::int32_t& at : places) at >>= tile.xy_shift;
  }
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 0; i < z_.size(); ++i) {
    tile.missing.push_back(std::isnan(samples_m_[i]));
    if (!tile.missing[i]) lowest = std::min(lowest, z_[i]);
  }
  for (std::size_t i = 0; i < z_.size(); ++i) {
    tile.z.push_back(tile.missing[i] ? 0 : static_cast<std::int32_t>(z_[i] - lowest));
  }
  tile.z_offset = lowest;
  if (std::ranges::find(tile.missing, true) == tile.missing.end()) tile.missing.clear();
  return tile.mesh();
}

}  // namespace tintree::simplify
