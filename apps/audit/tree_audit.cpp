#include "apps/audit/tree_audit.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include "apps/audit/file_audit.h"
#include "apps/audit/hausdorff_probe.h"
#include "apps/audit/level_walk.h"

namespace tintree::audit {
namespace {

/// Chooses the tiles for CGAL: the same ones for the same tree.
constexpr std::uint64_t kSeed = 20040901;

class TreeWalk {
 public:
  TreeWalk(const cache::TileStore& store, const cache::RasterSource& source, const AuditOptions& options)
      : options_(options), layout_(store.manifest().layout), context_{store, source, [this](std::int64_t cells) {
                                                                        return advance(cells);
                                                                      }} {}

  Expected<TreeReport> run() {
    const auto begun = std::chrono::steady_clock::now();
    begin_step("Comparing digests", static_cast<std::uint64_t>((layout_.columns - 1) * (layout_.rows - 1)));
    auto of_file = audit_file(context_);
    if (!of_file) return tl::unexpected(of_file.error());
    report_.violations = *of_file;
    if (auto done = walk_levels(); !done) return tl::unexpected(done.error());
    for (const Violation& v : *of_file) {
      if (v.tile) ++report_.levels[static_cast<std::size_t>(v.tile->level)].violations;
    }
    if (auto done = probe(); !done) return tl::unexpected(done.error());
    report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return std::move(report_);
  }

 private:
  Expected<void> walk_levels() {
    const auto begun = std::chrono::steady_clock::now();
    std::uint64_t samples = 0;
    std::vector<bool> empty_parents;
    std::vector<LevelLines> coarser;
    for (int level = 0; level <= layout_.leaf_level; ++level) {
      begin_step(fmt::format("Measuring level {} of {}", level, layout_.leaf_level),
                 static_cast<std::uint64_t>((layout_.columns - 1) * (layout_.rows - 1)));
      const auto under_empty = [&](const codec::TileId& id) {
        if (level == 0) return false;
        const codec::TileId parent = layout_.parent(id);
        return static_cast<bool>(empty_parents[std::size_t{parent.y} * layout_.tiles_x(parent.level) + parent.x]);
      };
      LevelWalk walk(context_, level, coarser, under_empty, options_.map_px);
      auto report = walk.run(report_);
      if (!report) return tl::unexpected(report.error());
      empty_parents = walk.empty();
      coarser.push_back(walk.take_lines());
      samples += report->samples;
      report_.levels.push_back(*report);
    }
    const std::chrono::duration<double> measuring = std::chrono::steady_clock::now() - begun;
    report_.samples_per_second = static_cast<double>(samples) / measuring.count();
    return {};
  }

  bool advance(std::int64_t cells) {
    const std::uint64_t done = done_ += static_cast<std::uint64_t>(cells);
    if (options_.progress) options_.progress(step_, std::min(done, total_), total_);
    return !(options_.stop && options_.stop());
  }

  void begin_step(std::string step, std::uint64_t total) {
    step_ = std::move(step);
    done_ = 0;
    total_ = total;
  }

  std::vector<codec::TileId> choose_tiles() const {
    std::vector<codec::TileId> chosen;
    std::mt19937_64 random(kSeed);
    for (int level = 0; level <= layout_.leaf_level; ++level) {
      std::vector<codec::TileId> tiles;
      for (const cache::TileNode& node : context_.store.bounds().nodes()) {
        if (node.id.level == level) tiles.push_back(node.id);
      }
      for (int i = 0; i < options_.hausdorff_tiles && !tiles.empty(); ++i) {
        const auto pick = static_cast<std::ptrdiff_t>(random() % tiles.size());
        chosen.push_back(tiles[static_cast<std::size_t>(pick)]);
        tiles.erase(tiles.begin() + pick);
      }
    }
    return chosen;
  }

  Expected<void> probe() {
    const std::vector<codec::TileId> tiles = choose_tiles();
    std::vector<Expected<std::optional<HausdorffReport>>> found(tiles.size());
    begin_step("CGAL's Hausdorff distance", tiles.size());
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
      if (options_.stop && options_.stop()) {
        found[i] = tl::unexpected(stopped_error());
        return;
      }
      found[i] = probe_tile(context_, tiles[i], kSeed + i);
      advance(1);
    });
    for (auto& one : found) {
      if (!one) return tl::unexpected(one.error());
      if (*one) judge(**one);
    }
    return {};
  }

  void judge(const HausdorffReport& probe) {
    report_.hausdorff.push_back(probe);
    // CGAL returns its error bound where the true distance is less.
    const double limit = std::max(probe.vertical_max_m + probe.error_bound_m, probe.error_bound_m);
    if (probe.hausdorff_m <= limit * (1 + 1e-9)) return;
    LevelReport& level = report_.levels[static_cast<std::size_t>(probe.tile.level)];
    ++level.violations;
    report_.violations.push_back(
        {probe.tile, ViolationKind::kHausdorff,
         fmt::format("CGAL finds a Hausdorff distance of {:.9g} m where the vertical maximum is {:.9g} m",
                     probe.hausdorff_m, probe.vertical_max_m),
         probe.hausdorff_m / level.bound_m});
  }

  const AuditOptions& options_;
  const codec::TreeLayout& layout_;
  AuditContext context_;
  TreeReport report_;
  std::string step_;
  std::atomic<std::uint64_t> done_{0};
  std::uint64_t total_ = 0;
};

}  // namespace

const Violation* TreeReport::worst() const {
  const auto at = std::ranges::max_element(violations, {}, &Violation::severity);
  return at == violations.end() ? nullptr : &*at;
}

Expected<void> match(const cache::Manifest& manifest, const cache::RasterInfo& dem) {
  const codec::TreeLayout& tree = manifest.layout;
  const auto bad = [&dem](std::string message) {
    return fail(ErrorCode::kBadData, message + "; give the DEM that the tree was built from", dem.path);
  };
  if (tree.columns != dem.columns || tree.rows != dem.rows) {
    return bad(fmt::format("is {} x {} samples, but the tree was built from {} x {}", dem.columns, dem.rows,
                           tree.columns, tree.rows));
  }
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-12 * std::abs(a); };
  if (!near(tree.dx_m, dem.dx_m) || !near(tree.dy_m, dem.dy_m)) {
    return bad(fmt::format("has samples {:.9g} x {:.9g} m apart, but the tree was built from {:.9g} x {:.9g} m",
                           dem.dx_m, dem.dy_m, tree.dx_m, tree.dy_m));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const double turn =
        std::abs(tree.axes.column[i] - dem.axes.column[i]) + std::abs(tree.axes.row[i] - dem.axes.row[i]);
    if (turn > 1e-9) return bad("is turned another way than the tree");
  }
  if (!near(manifest.height_unit_m, dem.height_unit_m)) {
    return bad(fmt::format("counts heights in units of {:.9g} m, but the tree was built with {:.9g} m",
                           dem.height_unit_m, manifest.height_unit_m));
  }
  if (dem.columns > kMaxSide || dem.rows > kMaxSide) {
    return fail(ErrorCode::kBadData,
                fmt::format("has a side longer than the {} samples that an audit can measure", kMaxSide), dem.path);
  }
  return {};
}

Expected<TreeReport> audit_tree(const cache::TileStore& store, const cache::RasterSource& source,
                                const AuditOptions& options) {
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  }
  return TreeWalk(store, source, options).run();
}

}  // namespace tintree::audit
