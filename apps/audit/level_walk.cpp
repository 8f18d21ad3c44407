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

LevelWalk::LevelWalk(const AuditContext& context, int level, std::function<bool(const codec::TileId&)> skip)
    : context_(context), skip_(std::move(skip)) {
  const codec::TreeLayout& layout = context.store.manifest().layout;
  report_.level = level;
  report_.bound_m = layout.bound_m(level);
  tiles_x_ = layout.tiles_x(level);
  tiles_y_ = layout.tiles_y(level);
  z_step_m_ = layout.z_step_m[static_cast<std::size_t>(level)];
  empty_.assign(std::size_t{tiles_x_} * tiles_y_, false);
  south_.resize(tiles_x_);
}

codec::TileId LevelWalk::tile_at(std::uint64_t index) const {
  return {report_.level, static_cast<std::uint32_t>(index % tiles_x_), static_cast<std::uint32_t>(index / tiles_x_)};
}

Expected<LevelReport> LevelWalk::run(std::vector<Violation>& violations) {
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
    if (!skip_(id)) return std::make_shared<Expected<TileReport>>(audit_tile(context_, id));
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
    account(**tile);
    std::ranges::move((*tile)->violations, std::back_inserter(violations));
  };
  const auto in_flight = static_cast<std::size_t>(2 * tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(in_flight, tbb::make_filter<void, std::uint64_t>(tbb::filter_mode::serial_in_order, take) &
                                        tbb::make_filter<std::uint64_t, Examined>(tbb::filter_mode::parallel, examine) &
                                        tbb::make_filter<Examined, void>(tbb::filter_mode::serial_in_order, collect));
  if (first_error) return tl::unexpected(*first_error);
  report_.vertical_rms_m = report_.samples == 0 ? 0 : std::sqrt(sum_squares_m2_ / static_cast<double>(report_.samples));
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return report_;
}

void LevelWalk::account(TileReport& tile) {
  compare_borders(tile);
  empty_[std::size_t{tile.id.y} * tiles_x_ + tile.id.x] = tile.empty;
  report_.tiles += tile.present ? 1 : 0;
  report_.vertices += tile.vertices;
  report_.triangles += tile.triangles;
  report_.vertical_max_m = std::max(report_.vertical_max_m, tile.distance.overall.value_m);
  report_.border_max_m = std::max(report_.border_max_m, tile.distance.border.value_m);
  report_.samples += tile.distance.samples;
  sum_squares_m2_ += tile.distance.sum_squares_m2;
  report_.violations += tile.violations.size();
}

void LevelWalk::compare_borders(TileReport& tile) {
  const codec::TileId& id = tile.id;
  if (id.x > 0) compare_border(tile, kWest, {id.level, id.x - 1, id.y}, east_);
  if (id.y > 0) compare_border(tile, kNorth, {id.level, id.x, id.y - 1}, south_[id.x]);
  east_ = std::move(tile.sides[kEast]);
  south_[id.x] = std::move(tile.sides[kSouth]);
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
