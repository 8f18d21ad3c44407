#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for_each.h>

#include "simplify/error_meter.h"
#include "simplify/tree_builder.h"

namespace tintree::simplify {
namespace {

using codec::TileId;

/// A mesh on the way from the root to a leaf, and those of its triangles that reach the tile we are at.
struct Layer {
  const MeasuredMesh* mesh;
  MeasuredError* error;
  std::vector<std::uint32_t> which;
};

/// Those of the layer's triangles whose bounding box meets the cells.
Layer narrowed(const Layer& layer, const codec::CellRect& cells) {
  Layer out{layer.mesh, layer.error, {}};
  const auto west = static_cast<double>(cells.column0);
  const auto east = static_cast<double>(cells.column1);
  const auto north = static_cast<double>(cells.row0);
  const auto south = static_cast<double>(cells.row1);
  for (const std::uint32_t k : layer.which) {
    const codec::Triangle& t = layer.mesh->triangles[k];
    const auto& a = layer.mesh->vertices[t[0]];
    const auto& b = layer.mesh->vertices[t[1]];
    const auto& c = layer.mesh->vertices[t[2]];
    const bool apart = std::max({a.column, b.column, c.column}) < west ||
                       std::min({a.column, b.column, c.column}) > east || std::max({a.row, b.row, c.row}) < north ||
                       std::min({a.row, b.row, c.row}) > south;
    if (!apart) out.which.push_back(k);
  }
  return out;
}

Layer whole(const MeasuredMesh& mesh, MeasuredError& error) {
  Layer layer{&mesh, &error, std::vector<std::uint32_t>(mesh.triangles.size())};
  std::iota(layer.which.begin(), layer.which.end(), 0U);
  return layer;
}

/// The pass over the tree. The tiles above a split level are decoded once and shared; each subtree below is
/// one task. Sums are added up in a fixed order, so the result does not depend on the threads.
class Pass {
 public:
  Pass(const ReferenceSurface& surface, const cache::Manifest& manifest, cache::TileWriter& writer,
       const ProgressFn& progress)
      : surface_(&surface),
        manifest_(&manifest),
        writer_(&writer),
        progress_(&progress),
        decoder_(manifest, [this](const TileId& id) { return read(id); }) {}

  Expected<void> run();
  const std::map<std::int64_t, MeasuredError>& results() const { return results_; }

 private:
  static constexpr int kSplitHalvings = 3;

  struct Task {
    TileId root;
    std::vector<MeasuredError> above;  // what this subtree adds to each level above it
    std::map<std::int64_t, MeasuredError> within;
  };

  Expected<cache::StoredTile> read(const TileId& id) {
    const std::scoped_lock lock(turn_);
    return writer_->read(id);
  }
  std::optional<MeasuredMesh> load(const TileId& id);
  void run_task(Task& task);
  void visit(const TileId& id, const std::vector<Layer>& layers, Task& task, ErrorMeter& meter);
  void stop_with(const Error& error);
  bool present(const TileId& id) const { return std::ranges::binary_search(keys_, id.key()); }

  const ReferenceSurface* surface_;
  const cache::Manifest* manifest_;
  cache::TileWriter* writer_;
  const ProgressFn* progress_;
  cache::TileDecoder decoder_;
  std::vector<std::int64_t> keys_;
  std::map<std::int64_t, MeasuredMesh> shared_;
  std::map<std::int64_t, MeasuredError> results_;
  std::mutex turn_;
  std::optional<Error> error_;
  std::atomic<bool> halt_ = false;
  std::uint64_t leaves_done_ = 0;
  std::uint64_t leaves_ = 0;
};

void Pass::stop_with(const Error& error) {
  const std::scoped_lock lock(turn_);
  if (!error_) error_ = error;
  halt_ = true;
}

std::optional<MeasuredMesh> Pass::load(const TileId& id) {
  const auto tile = read(id);
  if (tile) {
    auto mesh = decoder_.decode(*tile);
    if (mesh) return MeasuredMesh(manifest_->layout, id, *mesh);
    stop_with(mesh.error());
  } else {
    stop_with(tile.error());
  }
  return std::nullopt;
}

void Pass::visit(const TileId& id, const std::vector<Layer>& layers, Task& task, ErrorMeter& meter) {
  const codec::TreeLayout& layout = manifest_->layout;
  const codec::CellRect cells = layout.cells(id);
  if (halt_ || cells.empty()) return;
  std::vector<Layer> here;
  for (const Layer& layer : layers) {
    Layer part = narrowed(layer, cells);
    if (!part.which.empty()) here.push_back(std::move(part));
  }
  // Where the surface ends on its north or west side, a square without a tile still owns samples of the levels above.
  const bool has_tile = present(id);
  if (!has_tile && here.empty()) return;
  std::optional<MeasuredMesh> mesh;
  if (has_tile) {
    mesh = load(id);
    if (!mesh) return;
    here.push_back(whole(*mesh, task.within[id.key()]));
  }
  if (id.level < layout.leaf_level) {
    for (int i = 0; i < layout.child_count(id.level); ++i) visit(layout.child(id, i), here, task, meter);
    return;
  }
  meter.set_window(cells);
  for (const Layer& layer : here) *layer.error += meter.measure(*layer.mesh, layer.which);
  if (!has_tile) return;
  const std::scoped_lock lock(turn_);
  if (!(*progress_)("measuring", ++leaves_done_, leaves_)) halt_ = true;
}

void Pass::run_task(Task& task) {
  SurfaceView view(*surface_);
  ErrorMeter meter(view);
  task.above.resize(static_cast<std::size_t>(task.root.level));
  std::vector<Layer> layers;
  TileId id = task.root;
  while (id.level > 0) {
    id = manifest_->layout.parent(id);
    const auto mesh = shared_.find(id.key());
    if (mesh != shared_.end()) layers.push_back(whole(mesh->second, task.above[static_cast<std::size_t>(id.level)]));
  }
  visit(task.root, layers, task, meter);
  if (view.error()) stop_with(*view.error());
}

Expected<void> Pass::run() {
  auto keys = writer_->keys();
  if (!keys) return tl::unexpected(keys.error());
  keys_ = std::move(*keys);
  const int leaf_level = manifest_->layout.leaf_level;
  const int split = std::min(manifest_->layout.coarsest_level(kSplitHalvings), leaf_level);
  std::vector<Task> tasks;
  for (const std::int64_t key : keys_) {
    const TileId id = TileId::from_key(key);
    if (id.level == leaf_level) ++leaves_;
    if (id.level < split) {
      auto mesh = load(id);
      if (!mesh) return tl::unexpected(*error_);
      shared_.emplace(key, std::move(*mesh));
    }
  }
  for (std::uint32_t y = 0; y < manifest_->layout.tiles_y(split); ++y) {
    for (std::uint32_t x = 0; x < manifest_->layout.tiles_x(split); ++x) tasks.push_back({{split, x, y}, {}, {}});
  }
  tbb::parallel_for_each(tasks, [this](Task& task) { run_task(task); });
  if (error_) return tl::unexpected(*error_);
  if (halt_) return fail(ErrorCode::kStopped, "stopped");
  for (Task& task : tasks) {
    results_.merge(task.within);
    TileId id = task.root;
    while (id.level > 0) {
      id = manifest_->layout.parent(id);
      if (shared_.contains(id.key())) results_[id.key()] += task.above[static_cast<std::size_t>(id.level)];
    }
  }
  return {};
}

}  // namespace

Expected<void> measure_tiles(const ReferenceSurface& surface, const cache::Manifest& manifest,
                             cache::TileWriter& writer, std::vector<LevelSummary>& levels, const ProgressFn& progress) {
  Pass pass(surface, manifest, writer, progress);
  if (auto done = pass.run(); !done) return done;
  std::vector<MeasuredError> totals(levels.size());
  for (const auto& [key, error] : pass.results()) {
    auto tile = writer.read(TileId::from_key(key));
    if (!tile) return tl::unexpected(tile.error());
    tile->info.error_m = error.max_m;
    tile->info.rms_m = error.rms_m();
    tile->info.border_error_m = error.border_max_m;
    if (auto put = writer.put(*tile); !put) return put;
    const int level = tile->info.id.level;
    const double bound = manifest.layout.bound_m(level);
    if (error.max_m > bound) {
      return fail(ErrorCode::kCheckFailed,
                  fmt::format("its measured error of {:.9g} m exceeds its bound of {:.9g} m; this is a fault of the "
                              "program, please report it",
                              error.max_m, bound),
                  "tile " + tile->info.id.text());
    }
    levels[static_cast<std::size_t>(level)].add(*tile, manifest.method);
    totals[static_cast<std::size_t>(level)] += error;
  }
  for (std::size_t l = 0; l < levels.size(); ++l) {
    levels[l].error_m = totals[l].max_m;
    levels[l].rms_m = totals[l].rms_m();
  }
  return writer.commit();
}

}  // namespace tintree::simplify
