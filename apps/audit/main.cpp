/// tintree-audit: re-reads a finished tree against its DEM and proves or refutes what the tree claims.

#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/audit/report.h"
#include "apps/audit/tree_audit.h"
#include "apps/common/json_file.h"
#include "apps/common/program.h"
#include "apps/common/progress.h"

namespace {

using tintree::Expected;

/// What GDAL may keep of decoded blocks: a few rows of tiles of a wide raster.
constexpr std::uint64_t kRasterCacheBytes = std::uint64_t{128} << 20;

struct Options {
  std::string tree;
  std::string dem;
  std::string json;
  bool quiet = false;
  tintree::audit::AuditOptions audit;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("TREE", o.tree, "The tree to examine (.tintree)")->required();
  app.add_option("--dem", o.dem, "The elevation model that the tree was built from")->required();
  app.add_option("--json", o.json, "Also write the report to this file as JSON");
  app.add_option("--hausdorff-tiles", o.audit.hausdorff_tiles,
                 "Tiles a level whose Hausdorff distance CGAL computes too; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.add_option("--threads", o.audit.threads, "Threads; 0: one a core")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_flag("--quiet", o.quiet, "Print the verdict only");
}

Expected<void> run(const Options& o) {
  tintree::cache::set_raster_cache_bytes(kRasterCacheBytes);
  const auto store = tintree::cache::TileStore::open(o.tree);
  if (!store) return tl::unexpected(store.error());
  const auto source = tintree::cache::RasterSource::open(o.dem);
  if (!source) return tl::unexpected(source.error());
  if (auto matches = tintree::audit::match(store->manifest(), source->info()); !matches) return matches;

  tintree::app::Progress progress(o.quiet);
  tintree::audit::AuditOptions options = o.audit;
  options.stop = tintree::app::stop_requested;
  options.progress = [&progress](const std::string& step, std::uint64_t done, std::uint64_t total) {
    progress.report(step, done, total);
  };
  const auto report = tintree::audit::audit_tree(*store, *source, options);
  progress.close();
  if (!report) return tl::unexpected(report.error());

  if (!o.quiet) fmt::print("{}", report_text(*report));
  const std::string verdict = tintree::audit::verdict(*report);
  fmt::print("{}\n", verdict);
  if (!o.json.empty()) {
    nlohmann::ordered_json json = tintree::audit::report_json(*report);
    json["peak_rss_bytes"] = tintree::app::peak_rss_bytes();
    if (auto written = tintree::app::write_json(o.json, json); !written) return written;
  }
  if (!report->violations.empty()) return tintree::fail(tintree::ErrorCode::kCheckFailed, verdict, o.tree);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Measures every tile of a tree against its elevation model. Exit code 0: all promises hold; 1: some do not.",
      "tintree-audit");
  Options options;
  declare(app, options);
  return tintree::app::run_program(app, argc, argv, [&options] { return run(options); });
}
