#include "apps/audit/tile_audit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include "apps/audit/coverage.h"
#include "apps/audit/height_window.h"
#include "apps/audit/topology.h"
#include "apps/audit/window_bins.h"

namespace tintree::audit {
namespace {

constexpr double kFigureTolerance = 1e-9;
/// A root mean square is a long sum, whose order the builder may choose.
constexpr double kRmsTolerance = 1e-6;

/// Everything measured in one window.
struct WindowReport {
  VerticalDistance distance;
  Coverage::Result coverage;
};

/// Working memory of one thread.
struct Workbench {
  HeightWindow window;
  VerticalMeasure measure;
  Coverage coverage;
};

tbb::enumerable_thread_specific<Workbench>& workbenches() {
  static tbb::enumerable_thread_specific<Workbench> benches;
  return benches;
}

/// Runs `work(window, bench)` for windows 0 to count - 1 on all cores and returns the first error.
template <typename Work>
std::optional<Error> for_each_window(std::size_t count, const Work& work) {
  std::atomic<bool> failed{false};
  std::vector<std::optional<Error>> errors(count);
  // Isolated: a thread that waits here must not begin another tile meanwhile.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (failed) return;
      errors[i] = work(i, workbenches().local());
      if (errors[i]) failed = true;
    });
  });
  const auto first = std::ranges::find_if(errors, [](const auto& e) { return e.has_value(); });
  return first == errors.end() ? std::nullopt : *first;
}

class TileExamination {
 public:
  TileExamination(const AuditContext& context, const codec::TileId& id, ErrorMap* map)
      : context_(context), layout_(context.store.manifest().layout), bound_m_(layout_.bound_m(id.level)), map_(map) {
    report_.id = id;
  }

  Expected<TileReport> run() {
    const bool listed = context_.store.bounds().find(report_.id) >= 0;
    auto done = listed ? examine_tile() : examine_absence();
    if (!done) return tl::unexpected(done.error());
    return std::move(report_);
  }

 private:
  void blame(ViolationKind kind, std::string message, double severity = kStructural) {
    report_.violations.push_back({report_.id, kind, std::move(message), severity});
  }
  void blame(ViolationKind kind, const Faults& faults) {
    if (faults.count == 0) return;
    blame(kind,
          faults.count == 1 ? faults.first : fmt::format("{} (and {} more places)", faults.first, faults.count - 1));
  }

  /// A tile that the tree lacks: right only where the DEM has no surface.
  Expected<void> examine_absence() {
    const TileSurface nothing = place(layout_, report_.id, {});
    const WindowBins bins(nothing);
    std::atomic<bool> surface{false};
    const auto error = for_each_window(bins.count(), [&](std::size_t i, Workbench& bench) -> std::optional<Error> {
      const codec::CellRect cells = bins.cells(i);
      if (!surface) {
        if (auto read = bench.window.read(context_.source, nothing.cells, cells); !read) return read.error();
        if (bench.window.has_surface()) surface = true;
      }
      return tell(cells);
    });
    if (error) return tl::unexpected(*error);
    report_.empty = !surface;
    if (surface) blame(ViolationKind::kMissingTile, "the tree has no tile where the DEM has surface");
    return {};
  }

  Expected<void> examine_tile() {
    auto stored = context_.store.read(report_.id);
    auto mesh = stored ? context_.store.decode(*stored) : tl::unexpected(stored.error());
    if (!mesh) {
      if (mesh.error().code != ErrorCode::kBadData) return tl::unexpected(mesh.error());
      blame(ViolationKind::kFile, mesh.error().message);
      const codec::CellRect cells = layout_.cells(report_.id);
      if (auto error = tell(cells)) return tl::unexpected(*error);
      return {};
    }
    report_.present = true;
    report_.vertices = mesh->vertices.size();
    report_.triangles = mesh->triangles.size();
    report_.bytes = stored->payload.size();
    const TileSurface surface = place(layout_, report_.id, std::move(*mesh));
    report_.sides = side_lines(surface);
    Faults topology;
    Expected<void> measured;
    tbb::this_task_arena::isolate([&] {
      tbb::parallel_invoke([&] { measured = measure(surface); }, [&] { topology = check_topology(surface); });
    });
    if (!measured) return measured;
    blame(ViolationKind::kTopology, topology);
    judge(surface, stored->info);
    return {};
  }

  Expected<void> measure(const TileSurface& surface) {
    const WindowBins bins(surface);
    std::vector<WindowReport> windows(bins.count());
    const auto error = for_each_window(bins.count(), [&](std::size_t i, Workbench& bench) -> std::optional<Error> {
      const codec::CellRect cells = bins.cells(i);
      if (auto read = bench.window.read(context_.source, surface.cells, cells); !read) return read.error();
      windows[i].distance =
          bench.measure.measure(surface, bench.window, {bins.triangles(i), bins.edges(i), bins.corners(i)});
      windows[i].coverage = bench.coverage.check(surface, bench.window, bins.edges(i));
      file(surface, bench.measure.sample_errors(), windows[i].distance.overall);
      return tell(cells);
    });
    if (error) return tl::unexpected(*error);
    // Summed in the order of the windows: the same figures at any number of threads.
    Faults coverage = place_open_edges(surface);
    std::uint64_t reference_triangles = 0;
    for (const WindowReport& w : windows) {
      report_.distance.add(w.distance);
      coverage.add(w.coverage.faults);
      reference_triangles += w.coverage.reference_triangles;
    }
    judge_coverage(surface, std::move(coverage), reference_triangles);
    return {};
  }

  void file(const TileSurface& surface, const SampleErrors& errors, const Peak& peak) {
    ErrorHistogram histogram;
    histogram.add(errors.values_m, bound_m_);
    {
      const std::scoped_lock lock(turn_);
      report_.histogram.add(histogram);
    }
    if (map_ != nullptr) map_->add(surface.cells.column0, surface.cells.row0, errors, peak);
  }

  std::optional<Error> tell(const codec::CellRect& cells) const {
    const std::int64_t count = (cells.column1 - cells.column0) * (cells.row1 - cells.row0);
    return context_.advance(count) ? std::nullopt : std::optional(stopped_error());
  }

  void judge_coverage(const TileSurface& surface, Faults faults, std::uint64_t reference_triangles) {
    if (reference_triangles == 0) {
      return blame(ViolationKind::kExtraTile, "the tree has a tile where the DEM has no surface");
    }
    const std::int64_t unit = std::int64_t{surface.units} * surface.units;
    const std::int64_t expected = static_cast<std::int64_t>(reference_triangles) * unit;
    const std::int64_t area = doubled_area(surface);
    if (area != expected && faults.count == 0) {
      faults.add(fmt::format("the mesh covers {} cells where the surface has {}",
                             static_cast<double>(area) / (2.0 * static_cast<double>(unit)),
                             static_cast<double>(reference_triangles) / 2));
    }
    blame(ViolationKind::kCoverage, faults);
  }

  void judge(const TileSurface& surface, const cache::TileInfo& info) {
    const Peak& peak = report_.distance.overall;
    if (peak.value_m > bound_m_ * (1 + kFigureTolerance)) {
      blame(ViolationKind::kBound,
            fmt::format("is {:.9g} m from the surface at column {:.10g}, row {:.10g} of the DEM; its bound is {:.9g} m",
                        peak.value_m, static_cast<double>(surface.cells.column0) + peak.column,
                        static_cast<double>(surface.cells.row0) + peak.row, bound_m_),
            peak.value_m / bound_m_);
    }
    compare_figure("error_m", info.error_m, peak.value_m, figure_tolerance(peak.value_m));
    const double border = report_.distance.border.value_m;
    compare_figure("border_error_m", info.border_error_m, border, figure_tolerance(border));
    const auto samples = static_cast<double>(std::max<std::uint64_t>(report_.distance.samples, 1));
    const double rms = std::sqrt(report_.distance.sum_squares_m2 / samples);
    compare_figure("rms_m", info.rms_m, rms, kRmsTolerance * (1 + rms));
    judge_range(surface, info);
    if (info.vertices != report_.vertices || info.triangles != report_.triangles) {
      blame(ViolationKind::kStoredFigure,
            fmt::format("states {} vertices and {} triangles but holds {} and {}", info.vertices, info.triangles,
                        report_.vertices, report_.triangles),
            1);
    }
  }

  void compare_figure(const char* name, double stored, double measured, double tolerance) {
    if (std::abs(stored - measured) <= tolerance) return;
    blame(ViolationKind::kStoredFigure,
          fmt::format("states {} {:.12g} but {:.12g} is measured", name, stored, measured),
          std::isfinite(stored) ? std::abs(stored - measured) / bound_m_ : kStructural);
  }

  /// Heights as stored with the tile, and the box that a viewer culls by.
  void judge_range(const TileSurface& surface, const cache::TileInfo& info) {
    if (surface.corners.empty()) return;
    const auto [low, high] = std::ranges::minmax(surface.corners, {}, &Corner::z_m);
    compare_figure("z_min_m", info.z_min_m, low.z_m, figure_tolerance(low.z_m));
    compare_figure("z_max_m", info.z_max_m, high.z_m, figure_tolerance(high.z_m));
    const cache::TileBounds& bounds = context_.store.bounds();
    const cache::TileNode& node = bounds.nodes()[static_cast<std::size_t>(bounds.find(report_.id))];
    const double lod_error = std::max(report_.distance.overall.value_m, 2 * report_.distance.border.value_m);
    const double slack = figure_tolerance(lod_error);
    if (node.z_min_m > low.z_m || node.z_max_m < high.z_m || node.lod_error_m < lod_error - slack) {
      blame(ViolationKind::kHierarchy,
            fmt::format("lies outside its entry in the hierarchy of bounding boxes: heights {:.9g} to {:.9g} m, error "
                        "{:.9g} m, there {:.9g} to {:.9g} m, {:.9g} m",
                        low.z_m, high.z_m, lod_error, node.z_min_m, node.z_max_m, node.lod_error_m),
            1);
    }
  }

  const AuditContext& context_;
  const codec::TreeLayout& layout_;
  double bound_m_;
  ErrorMap* map_;
  std::mutex turn_;  ///< Guards the report's histogram.
  TileReport report_;
};

}  // namespace

double figure_tolerance(double measured) { return kFigureTolerance * (1 + std::abs(measured)); }

Error stopped_error() { return {ErrorCode::kStopped, "stopped before the audit was complete", {}}; }

Expected<TileReport> audit_tile(const AuditContext& context, const codec::TileId& id, ErrorMap* map) {
  return TileExamination(context, id, map).run();
}

}  // namespace tintree::audit
