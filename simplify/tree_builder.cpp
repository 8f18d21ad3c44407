#include "simplify/tree_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <atomic>
#include <optional>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "codec/mesh_codec.h"
#include "codec/strip_list.h"
#include "simplify/stored_tile.h"
#include "simplify/tile_maker.h"

namespace tintree::simplify {
namespace {

using codec::TileId;

constexpr double kStepsPerBound = 4;
/// Steps from height 0 up to which the guard against rounding (tested_bound_m) is next to nothing of a step.
constexpr double kMaxSteps = 0x1p40;
/// Errors and heights of which every product that a test in float forms can be formed, metres.
constexpr double kLeastError = 1e-30;
constexpr double kMostError = 1e30;
constexpr double kMostHeight = 1e30;
/// Places in a tile are counted in 32 bits, at half samples.
constexpr std::int64_t kMostCells = std::int64_t{1} << 29;

/// The largest height difference within any tile of the level.
double largest_relief(const ReferenceSurface& surface, const codec::TreeLayout& layout, int level) {
  double relief = 0;
  for (std::uint32_t y = 0; y < layout.tiles_y(level); ++y) {
    for (std::uint32_t x = 0; x < layout.tiles_x(level); ++x) {
      const auto range = surface.height_range_m(layout.cells({level, x, y}));
      relief = std::max(relief, range[1] - range[0]);
    }
  }
  return relief;
}

/// Fails where not even floating-point numbers hold what has to be computed.
Expected<void> check_scale(const codec::TreeLayout& layout, double farthest_m) {
  if (layout.leaf_level > codec::kMaxLevel) {
    return fail(ErrorCode::kBadData,
                fmt::format("would be a tree of {} levels, more than {}; choose a larger --tile, or "
                            "--levels-per-doubling 1",
                            layout.leaf_level + 1, codec::kMaxLevel + 1));
  }
  if (layout.cells_across(0) > kMostCells) {
    return fail(ErrorCode::kBadData,
                fmt::format("has more than {} samples along a side; build it in parts", kMostCells));
  }
  if (farthest_m > kMostHeight) {
    return fail(ErrorCode::kBadData,
                fmt::format("heights reach {:.3g} m, which is no elevation; mark wrong samples as nodata "
                            "(gdal_edit.py -a_nodata VALUE)",
                            farthest_m));
  }
  if (layout.leaf_error_m < kLeastError) {
    return fail(ErrorCode::kUsage,
                fmt::format("an error of {:.3g} m is too small to compute with; choose --error {} or "
                            "more",
                            layout.leaf_error_m, kLeastError));
  }
  if (layout.bound_m(0) > kMostError) {
    codec::TreeLayout of_a_metre = layout;  // The bound itself may be infinite.
    of_a_metre.leaf_error_m = 1;
    return fail(ErrorCode::kUsage,
                fmt::format("an error of {:.3g} m is too large to compute with; choose --error {:.3g} or less",
                            layout.leaf_error_m, 0.9 * kMostError / of_a_metre.bound_m(0)));
  }
  return {};
}

/// How far some heights are beyond what the height lattice of a level holds.
struct Misfit {
  double factor = 0;  ///< The error would have to be this many times as large.
  double height_m = 0;
  int level = 0;
  bool from_zero = false;  ///< The height is a distance from 0, else a difference within a tile.
};

std::string advice(const Misfit& misfit, double leaf_error_m) {
  const std::string heights = misfit.from_zero
                                  ? fmt::format("heights lie up to {:.6g} m from 0, too far", misfit.height_m)
                                  : fmt::format("heights differ by up to {:.6g} m within a tile of level {}, too much",
                                                misfit.height_m, misfit.level);
  return fmt::format(
      "{} for the format at an error of {:.6g} m; choose --error {:.3g} or more, or mark wrong samples as "
      "nodata",
      heights, leaf_error_m, 1.1 * leaf_error_m * misfit.factor);
}

struct MadeTile {
  Expected<cache::StoredTile> tile;
  double seconds = 0;
};

MadeTile make_timed(TileMaker& maker, const codec::MeshCodec& codec, const codec::TreeLayout& layout,
                    const TileId& id) {
  const auto begun = std::chrono::steady_clock::now();
  MadeTile out{make_stored_tile(maker, codec, layout, id)};
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

/// Stores a tile at once, so that a killed build has lost no more than the tiles in the making.
Expected<void> keep(cache::TileWriter& writer, const cache::StoredTile& tile) {
  if (tile.payload.empty()) return {};
  auto done = writer.put(tile);
  return done ? writer.commit() : done;
}

}  // namespace

void LevelSummary::add(const cache::StoredTile& tile, std::string_view method) {
  ++tiles;
  vertices += tile.info.vertices;
  triangles += tile.info.triangles;
  bytes += tile.payload.size();
  if (method != "strip") return;
  const auto head = codec::read_strip_head(tile.payload);
  if (head && !codec::unpacks_on_card(*head)) ++drawn_as_meshes;
}

std::vector<LevelSummary> make_levels(const codec::TreeLayout& layout) {
  std::vector<LevelSummary> levels;
  for (int level = 0; level <= layout.leaf_level; ++level) {
    levels.push_back({.level = level, .bound_m = layout.bound_m(level)});
  }
  return levels;
}

Expected<std::vector<double>> choose_height_steps(const ReferenceSurface& surface, const codec::TreeLayout& layout) {
  const auto range = surface.height_range_m(layout.cells({0, 0, 0}));
  const double farthest = range[0] > range[1] ? 0 : std::max(std::abs(range[0]), std::abs(range[1]));
  if (auto computable = check_scale(layout, farthest); !computable) return tl::unexpected(computable.error());
  std::vector<double> steps;
  Misfit worst;
  for (int level = 0; level <= layout.leaf_level; ++level) {
    const double bound = layout.bound_m(level);
    // A vertex may lie off the samples by the bound.
    const double relief = largest_relief(surface, layout, level) + 2 * bound;
    const double step = bound / kStepsPerBound;
    steps.push_back(step);
    const Misfit too_high{relief / step / codec::kMaxHeightAddress, relief, level, false};
    const Misfit too_far{farthest / step / kMaxSteps, farthest, level, true};
    worst = std::max({worst, too_high, too_far}, [](const Misfit& a, const Misfit& b) { return a.factor < b.factor; });
  }
  if (worst.factor > 1) return fail(ErrorCode::kBadData, advice(worst, layout.leaf_error_m));
  return steps;
}

Expected<std::vector<LevelSummary>> make_tiles(const ReferenceSurface& surface, const cache::Manifest& manifest,
                                               cache::TileWriter& writer, const ProgressFn& progress,
                                               const StopFlag* stop) {
  const codec::TreeLayout& layout = manifest.layout;
  const codec::MeshCodec* codec = codec::find_codec(manifest.method);
  if (codec == nullptr) return fail(ErrorCode::kUsage, "method '" + manifest.method + "' is unknown", "--method");
  auto present = writer.keys();
  if (!present) return tl::unexpected(present.error());
  const std::unordered_set<std::int64_t> done_before(present->begin(), present->end());

  std::vector<TileId> todo = list_tiles(layout);
  const std::uint64_t total = todo.size();
  std::erase_if(todo, [&](const TileId& id) { return done_before.contains(id.key()); });

  std::vector<LevelSummary> levels = make_levels(layout);
  tbb::enumerable_thread_specific<std::unique_ptr<TileMaker>> makers(
      [&] { return make_tile_maker(manifest, surface, stop); });
  std::optional<Error> error;
  std::size_t next = 0;
  std::uint64_t done = total - todo.size();
  std::atomic<bool> halt = false;
  const auto tokens = static_cast<std::size_t>(4 * tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(
      tokens, tbb::make_filter<void, TileId>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
                if (halt || is_set(stop) || next == todo.size()) {
                  control.stop();
                  return TileId{};
                }
                return todo[next++];
              }) & tbb::make_filter<TileId, MadeTile>(tbb::filter_mode::parallel, [&](const TileId& id) {
                return make_timed(*makers.local(), *codec, layout, id);
              }) & tbb::make_filter<MadeTile, void>(tbb::filter_mode::serial_out_of_order, [&](const MadeTile& made) {
                // A failure does not cost the tiles that were in the making beside it.
                auto kept = made.tile ? keep(writer, *made.tile) : tl::unexpected(made.tile.error());
                if (!kept) {
                  if (!error) error = kept.error();
                  halt = true;
                  return;
                }
                LevelSummary& level = levels[static_cast<std::size_t>(made.tile->info.id.level)];
                level.tiles_made += made.tile->payload.empty() ? 0 : 1;
                level.make_seconds += made.seconds;
                if (!progress("tiles", ++done, total)) halt = true;
              }));
  if (error) return tl::unexpected(*error);
  if (done < total) return fail(ErrorCode::kStopped, "stopped");
  return levels;
}

}  // namespace tintree::simplify
