#include "simplify/sample_tiles.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for_each.h>

#include "codec/mesh_codec.h"
#include "simplify/error_meter.h"
#include "simplify/stored_tile.h"
#include "simplify/tree_builder.h"

namespace tintree::simplify {
namespace {

using codec::TileId;

/// Areas in leaves.
constexpr double kShare = 0.05;
constexpr double kLeastArea = 24;
constexpr double kMostTiles = 100;

/// Processor time of this thread.
double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::int64_t cell_count(const codec::TreeLayout& layout, const TileId& id) {
  const codec::CellRect r = layout.cells(id);
  return (r.column1 - r.column0) * (r.row1 - r.row0);
}

/// The tile's cells and a row of cells around them, which its border ribbons look at.
codec::CellRect with_margin(const codec::TreeLayout& layout, const TileId& id) {
  const codec::CellRect r = layout.cells(id);
  return {std::max<std::int64_t>(r.column0 - 1, 0), std::max<std::int64_t>(r.row0 - 1, 0),
          std::min(r.column1 + 1, layout.columns - 1), std::min(r.row1 + 1, layout.rows - 1)};
}

/// Makes a tile's figures; one for each thread.
class Sampler {
 public:
  Sampler(const ReferenceSurface& surface, const cache::Manifest& manifest, const StopFlag* stop)
      : manifest_(&manifest),
        view_(surface, stop),
        meter_(view_),
        maker_(make_tile_maker(manifest, surface, stop)),
        codec_(codec::find_codec(manifest.method)) {}

  Expected<void> run(SampledTile& out) {
    auto above = maker_->stand_in_above(out.id);
    if (!above) return tl::unexpected(above.error());
    double mark = thread_seconds();
    const auto lap = [&mark] {
      const double now = thread_seconds();
      return now - std::exchange(mark, now);
    };
    const auto tile = make_stored_tile(*maker_, *codec_, manifest_->layout, out.id);
    if (!tile) return tl::unexpected(tile.error());
    out.make_seconds = lap();
    out.vertices = tile->info.vertices;
    out.triangles = tile->info.triangles;
    out.bytes = tile->payload.size();
    if (out.id.level < manifest_->layout.leaf_level || tile->payload.empty()) return {};
    const auto mesh = cache::TileDecoder(*manifest_, std::move(*above)).decode(*tile);
    if (!mesh) return tl::unexpected(mesh.error());
    const MeasuredMesh measured(manifest_->layout, out.id, *mesh);
    std::vector<std::uint32_t> all(measured.triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    meter_.set_window(measured.cells);
    out.load_seconds = lap();
    static_cast<void>(meter_.measure(measured, all));
    out.measure_seconds = lap();
    return view_.error() ? Expected<void>(tl::unexpected(*view_.error())) : Expected<void>();
  }

 private:
  const cache::Manifest* manifest_;
  SurfaceView view_;
  ErrorMeter meter_;
  std::unique_ptr<TileMaker> maker_;
  const codec::MeshCodec* codec_;
};

}  // namespace

std::vector<LevelSample> choose_sample(const codec::TreeLayout& layout) {
  std::vector<std::vector<TileId>> tiles(static_cast<std::size_t>(layout.leaf_level) + 1);
  for (const TileId& id : list_tiles(layout)) tiles[static_cast<std::size_t>(id.level)].push_back(id);
  const double area = std::max(kShare * static_cast<double>(tiles.back().size()), kLeastArea);
  std::vector<LevelSample> levels;
  for (int l = 0; l <= layout.leaf_level; ++l) {
    const std::vector<TileId>& all = tiles[static_cast<std::size_t>(l)];
    LevelSample level{.level = l, .tiles = all.size(), .sample = {}};
    for (const TileId& id : all) level.cells += cell_count(layout, id);
    // Tiles at the DEM's end may be slivers: what one holds on average.
    const double one = static_cast<double>(tiles.back().size()) / static_cast<double>(all.size());
    const double wanted = one <= 2 * area ? std::max(std::floor(area / one), 1.0) : 0;
    const auto count = static_cast<std::size_t>(std::min({wanted, kMostTiles, static_cast<double>(all.size())}));
    for (std::size_t i = 0; i < count; ++i) {
      // Somewhere in each of `count` equal parts, by the golden ratio: not in step with the quadtree.
      const double golden = 0.6180339887498949 * static_cast<double>(i + 1);
      const double at = (static_cast<double>(i) + (golden - std::floor(golden))) / static_cast<double>(count);
      const auto k = static_cast<std::size_t>(at * static_cast<double>(all.size()));
      level.sample.push_back({.id = all[std::min(k, all.size() - 1)]});
      level.sampled_cells += cell_count(layout, level.sample.back().id);
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

Expected<std::vector<LevelSample>> sample_tiles(const std::shared_ptr<cache::HeightBlocks>& blocks,
                                                cache::Manifest manifest, const StopFlag* stop) {
  std::vector<LevelSample> levels = choose_sample(manifest.layout);
  std::vector<SampledTile*> todo;
  std::vector<codec::CellRect> windows;
  for (LevelSample& level : levels) {
    for (SampledTile& tile : level.sample) {
      todo.push_back(&tile);
      windows.push_back(with_margin(manifest.layout, tile.id));
    }
  }
  auto surface = ReferenceSurface::scan_windows(blocks, windows, stop);
  if (!surface) return tl::unexpected(surface.error());
  auto steps = choose_height_steps(**surface, manifest.layout);
  if (!steps) return tl::unexpected(steps.error());
  manifest.layout.z_step_m = std::move(*steps);
  tbb::enumerable_thread_specific<std::unique_ptr<Sampler>> samplers(
      [&] { return std::make_unique<Sampler>(**surface, manifest, stop); });
  std::mutex turn;
  std::optional<Error> error;
  tbb::parallel_for_each(todo, [&](SampledTile* tile) {
    if (auto done = samplers.local()->run(*tile); !done) {
      const std::scoped_lock lock(turn);
      error = done.error();
    }
  });
  if (error) return tl::unexpected(*error);
  return levels;
}

}  // namespace tintree::simplify
