#include "apps/audit/level_walk.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace tintree::audit {
namespace {

/// Gaps this near a pixel are rounding.
constexpr double kPixelTolerance = 1e-6;

double severity_of(const TileReport& tile, double bound_m) {
  double worst = tile.distance.overall.value_m / bound_m;
  for (const Violation& v : tile.violations) worst = std::max(worst, v.severity);
  return worst;
}

TileFigures figures_of(const TileReport& tile, const codec::TreeLayout& layout) {
  TileFigures f;
  f.id = tile.id;
  f.bound_m = layout.bound_m(tile.id.level);
  const codec::CellRect cells = layout.cells(tile.id);
  f.peak = tile.distance.overall;
  f.peak.column += static_cast<double>(cells.column0);
  f.peak.row += static_cast<double>(cells.row0);
  const auto samples = static_cast<double>(std::max<std::uint64_t>(tile.distance.samples, 1));
  f.rms_m = std::sqrt(tile.distance.sum_squares_m2 / samples);
  f.p999_m = p999_m(tile.histogram, f.bound_m, f.peak.value_m);
  f.vertices = tile.vertices;
  f.triangles = tile.triangles;
  f.bytes = tile.bytes;
  f.severity = severity_of(tile, f.bound_m);
  return f;
}

void keep_worst(std::vector<TileFigures>& worst, const TileFigures& tile) {
  const auto at = std::ranges::upper_bound(worst, tile.severity, std::ranges::greater{}, &TileFigures::severity);
  worst.insert(at, tile);
  if (worst.size() > kWorstTiles) worst.pop_back();
}

}  // namespace

LevelWalk::LevelWalk(const AuditContext& context, int level, const std::vector<LevelLines>& coarser,
                     std::function<bool(const codec::TileId&)> skip, int map_px)
    : context_(context), skip_(std::move(skip)), coarser_(coarser) {
  const codec::TreeLayout& layout = context.store.manifest().layout;
  report_.level = level;
  report_.bound_m = layout.bound_m(level);
  tiles_x_ = layout.tiles_x(level);
  tiles_y_ = layout.tiles_y(level);
  z_step_m_ = layout.z_step_m[static_cast<std::size_t>(level)];
  empty_.assign(std::size_t{tiles_x_} * tiles_y_, false);
  south_.resize(tiles_x_);
  if (map_px > 0) {
    report_.map = std::make_shared<ErrorMap>(codec::CellRect{0, 0, layout.columns - 1, layout.rows - 1}, map_px);
  }
  lines_.level = level;
  lines_.halvings = layout.halvings(level);
  lines_.z_step_m = z_step_m_;
  lines_.tiles_x = tiles_x_;
  if (level == layout.leaf_level) return;
  lines_.east.resize(empty_.size());
  lines_.south.resize(empty_.size());
}

codec::TileId LevelWalk::tile_at(std::uint64_t index) const {
  return {report_.level, static_cast<std::uint32_t>(index % tiles_x_), static_cast<std::uint32_t>(index / tiles_x_)};
}

Expected<LevelReport> LevelWalk::run(TreeReport& tree) {
  using Examined = std::shared_ptr<Expected<TileReport>>;
  const auto begun = std::chrono::steady_clock::now();
  std::uint64_t next = 0;
  std::optional<Error> error;
  const auto take = [&](tbb::flow_control& control) {
    if (next == empty_.size() || error) control.stop();
    return next++;
  };
  const auto examine = [&](std::uint64_t index) -> Examined {
    const codec::TileId id = tile_at(index);
    if (!skip_(id)) return std::make_shared<Expected<TileReport>>(audit_tile(context_, id, report_.map.get()));
    TileReport nothing;
    nothing.id = id;
    nothing.empty = true;
    return std::make_shared<Expected<TileReport>>(std::move(nothing));
  };
  std::optional<Error> first_error;
  const auto collect = [&](const Examined& tile) {
    if (first_error) return;
    if (!*tile) {
      first_error = tile->error();
      return;
    }
    account(**tile, tree);
    std::ranges::move((*tile)->violations, std::back_inserter(tree.violations));
  };
  const auto in_flight = static_cast<std::size_t>(2 * tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(in_flight, tbb::make_filter<void, std::uint64_t>(tbb::filter_mode::serial_in_order, take) &
                                        tbb::make_filter<std::uint64_t, Examined>(tbb::filter_mode::parallel, examine) &
                                        tbb::make_filter<Examined, void>(tbb::filter_mode::serial_in_order, collect));
  if (first_error) return tl::unexpected(*first_error);
  report_.vertical_rms_m = report_.samples == 0 ? 0 : std::sqrt(sum_squares_m2_ / static_cast<double>(report_.samples));
  report_.vertical_p999_m = p999_m(report_.histogram, report_.bound_m, report_.vertical_max_m);
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return report_;
}

void LevelWalk::account(TileReport& tile, TreeReport& tree) {
  compare_borders(tile);
  compare_levels(tile);
  keep_lines(tile);
  empty_[std::size_t{tile.id.y} * tiles_x_ + tile.id.x] = tile.empty;
  report_.tiles += tile.present ? 1 : 0;
  report_.vertices += tile.vertices;
  report_.triangles += tile.triangles;
  report_.bytes += tile.bytes;
  report_.vertical_max_m = std::max(report_.vertical_max_m, tile.distance.overall.value_m);
  report_.border_max_m = std::max(report_.border_max_m, tile.distance.border.value_m);
  report_.samples += tile.distance.samples;
  sum_squares_m2_ += tile.distance.sum_squares_m2;
  report_.histogram.add(tile.histogram);
  report_.violations += tile.violations.size();
  if (tile.present || !tile.violations.empty()) {
    keep_worst(tree.worst_tiles, figures_of(tile, context_.store.manifest().layout));
  }
}

void LevelWalk::compare_borders(TileReport& tile) {
  const codec::TileId& id = tile.id;
  if (id.x > 0) compare_border(tile, kWest, {id.level, id.x - 1, id.y}, east_);
  if (id.y > 0) compare_border(tile, kNorth, {id.level, id.x, id.y - 1}, south_[id.x]);
}

/// Hands the lines on to the tiles that come next, and to finer levels.
void LevelWalk::keep_lines(TileReport& tile) {
  if (!lines_.east.empty()) {
    lines_.east[lines_.index(tile.id)] = tile.sides[kEast];
    lines_.south[lines_.index(tile.id)] = tile.sides[kSouth];
  }
  east_ = std::move(tile.sides[kEast]);
  south_[tile.id.x] = std::move(tile.sides[kSouth]);
}

void LevelWalk::compare_levels(TileReport& tile) {
  if (!tile.present) return;
  for (const LevelLines& coarse : coarser_) {
    for (const Side side : {kWest, kNorth, kEast, kSouth}) compare_level(tile, side, coarse);
  }
}

/// A viewer takes a tile from where its error projects to a pixel on; two tiles of different levels thus meet
/// no nearer than where the larger of their errors is a pixel.
void LevelWalk::compare_level(TileReport& tile, Side side, const LevelLines& coarse) {
  const auto neighbour = coarse_neighbour(coarse, tile.id, lines_.halvings, side);
  if (!neighbour) return;
  const LineGap widest = widest_gap(*neighbour->line, coarse.z_step_m, tile.sides[side], z_step_m_);
  if (coarse.level == report_.level - 1) report_.gap_max_m = std::max(report_.gap_max_m, widest.gap_m);
  const auto pixel_m = std::max(lod_error_m(tile.id), lod_error_m(neighbour->tile));
  const double gap_px = widest.gap_m > 0 ? widest.gap_m / pixel_m : 0;
  report_.gap_max_px = std::max(report_.gap_max_px, gap_px);
  if (gap_px <= 1 + kPixelTolerance) return;
  tile.violations.push_back(
      {tile.id, ViolationKind::kGap,
       fmt::format("lies {:.6g} m apart from tile {} at {} {:.10g} of the DEM: {:.4g} pixels where the two may meet",
                   widest.gap_m, neighbour->tile.text(), side == kWest || side == kEast ? "row" : "column",
                   widest.position, gap_px),
       gap_px});
}

/// The error by which a viewer chooses the tile; 0 for one that is not there.
double LevelWalk::lod_error_m(const codec::TileId& id) const {
  const cache::TileBounds& bounds = context_.store.bounds();
  const std::int64_t at = bounds.find(id);
  return at < 0 ? 0 : static_cast<double>(bounds.nodes()[static_cast<std::size_t>(at)].lod_error_m);
}

void LevelWalk::compare_border(TileReport& tile, Side side, const codec::TileId& neighbour, const SideLine& line) {
  const auto fault = compare_sides(tile.sides[side], line);
  if (!fault) return;
  const char* along = side == kWest ? "row" : "column";
  const double gap_m = static_cast<double>(fault->height_difference) * z_step_m_;
  tile.violations.push_back(
      {tile.id, ViolationKind::kBorder,
       fmt::format(
           "differs from tile {} in {} edges of their common side, first at {} {:.10g} of the DEM, by up to {:.6g} m",
           neighbour.text(), fault->count, along, fault->position, gap_m),
       kStructural});
}

}  // namespace tintree::audit
