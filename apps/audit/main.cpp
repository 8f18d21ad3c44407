/// tintree-audit: re-reads a finished tree against its DEM and proves or refutes what the tree claims.

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/audit/image_audit.h"
#include "apps/audit/report.h"
#include "apps/audit/report_page.h"
#include "apps/audit/tree_audit.h"
#include "apps/common/json_file.h"
#include "apps/common/program.h"
#include "apps/common/progress.h"
#include "apps/common/whole_file.h"

namespace {

using tintree::Expected;

/// What GDAL may keep of decoded blocks: a few rows of tiles of a wide raster.
constexpr std::uint64_t kRasterCacheBytes = std::uint64_t{128} << 20;
/// Longest side of the report's error maps.
constexpr int kMapPx = 512;

struct Options {
  std::string tree;
  std::vector<std::string> dems;
  std::vector<std::string> orthos;
  std::string json;
  std::string report;
  bool images = false;
  bool quiet = false;
  tintree::audit::AuditOptions audit;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("TREE", o.tree, "The tree to examine (.tintree)")->required();
  app.add_option("--dem", o.dems, "The elevation models that the tree was built from, in the same order")->required();
  app.add_option("--ortho", o.orthos, "The photos that the textures were made from, to compare these with them");
  app.add_option("--json", o.json, "Also write the report to this file as JSON");
  app.add_option("--report", o.report, "Also write a page with maps, charts and pictures into this folder");
  app.add_flag("--images", o.images, "Also draw views and compare them with the full-resolution surface");
  app.add_option("--hausdorff-tiles", o.audit.hausdorff_tiles,
                 "Tiles a level whose Hausdorff distance CGAL computes too; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.add_option("--threads", o.audit.threads, "Threads; 0: one a core")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_flag("--quiet", o.quiet, "Print the verdict only");
}

std::string page_path(const std::string& folder) { return folder + "/index.html"; }

/// Makes the page's folder when it is not there, and refuses what could not be written after the audit.
Expected<void> prepare_outputs(const Options& o) {
  if (!o.json.empty()) {
    std::vector<std::string> inputs{o.tree};
    inputs.insert(inputs.end(), o.dems.begin(), o.dems.end());
    inputs.insert(inputs.end(), o.orthos.begin(), o.orthos.end());
    if (auto writable = tintree::app::check_output_file(o.json, inputs); !writable) return writable;
  }
  if (o.report.empty()) return {};
  std::error_code ec;
  std::filesystem::create_directories(o.report, ec);
  if (ec) return tintree::fail(tintree::ErrorCode::kIo, "cannot be made: " + ec.message(), o.report);
  return tintree::app::check_output_file(page_path(o.report));
}

Expected<void> write_report(const std::string& folder, const tintree::audit::ReportInput& input) {
  const auto page = tintree::audit::report_page(input);
  if (!page) return tl::unexpected(page.error());
  return tintree::app::write_whole_file(page_path(folder), *page);
}

/// Prints and writes what was found; fails when anything was.
Expected<void> publish(const Options& o, const tintree::audit::ReportInput& found) {
  if (!o.quiet) fmt::print("{}", report_text(found.tree, found.images, found.pictures));
  const std::string verdict = tintree::audit::verdict(found.tree);
  fmt::print("{}\n", verdict);
  if (!o.json.empty()) {
    nlohmann::ordered_json json = tintree::audit::report_json(found.tree, found.images, found.pictures);
    json["peak_rss_bytes"] = tintree::app::peak_rss_bytes();
    if (auto written = tintree::app::write_json(o.json, json); !written) return written;
  }
  if (!o.report.empty()) {
    if (auto written = write_report(o.report, found); !written) return written;
  }
  if (found.tree.violations.empty()) return {};
  return tintree::fail(tintree::ErrorCode::kCheckFailed, verdict, o.tree);
}

Expected<void> run(const Options& o) {
  tintree::cache::set_raster_cache_bytes(kRasterCacheBytes);
  const auto store = tintree::cache::TileStore::open(o.tree);
  if (!store) return tl::unexpected(store.error());
  auto source = tintree::cache::RasterSource::open(o.dems);
  if (!source) return tl::unexpected(source.error());
  if (auto matches = tintree::audit::match(store->manifest(), source->info()); !matches) return matches;
  if (auto ready = prepare_outputs(o); !ready) return ready;

  tintree::app::Progress progress(o.quiet);
  tintree::cache::StageOptions stage;
  stage.nodata = store->manifest().nodata;
  stage.folder = std::filesystem::temp_directory_path();
  stage.raster_cache_bytes = kRasterCacheBytes;
  stage.progress = [&progress](const std::string& step, std::uint64_t done, std::uint64_t total) {
    progress.report(step, done, total);
    return !tintree::app::stop_requested();
  };
  if (auto staged = source->stage(stage); !staged) return staged;
  tintree::audit::AuditOptions options = o.audit;
  options.stop = tintree::app::stop_requested;
  if (!o.report.empty()) options.map_px = kMapPx;
  options.progress = [&progress](const std::string& step, std::uint64_t done, std::uint64_t total) {
    progress.report(step, done, total);
  };
  std::optional<tintree::cache::OrthoSource> photos;
  if (!o.orthos.empty()) {
    auto opened = tintree::cache::OrthoSource::open(o.orthos, source->info());
    if (!opened) return tl::unexpected(opened.error());
    photos.emplace(std::move(*opened));
  }
  auto report = tintree::audit::audit_tree(*store, *source, options);
  if (!report) return tl::unexpected(report.error());
  const tintree::audit::AuditContext context{*store, *source,
                                             [](std::int64_t) { return !tintree::app::stop_requested(); }};
  std::optional<tintree::audit::PictureReport> pictures;
  if (store->manifest().texture_size > 0 || store->manifest().normal_maps) {
    auto examined = tintree::audit::audit_pictures(context, photos ? &*photos : nullptr, report->violations);
    if (!examined) return tl::unexpected(examined.error());
    pictures.emplace(*examined);
  }
  std::optional<tintree::audit::ImageReport> images;
  if (o.images) {
    auto compared = tintree::audit::audit_images(context, {}, report->violations);
    if (!compared) return tl::unexpected(compared.error());
    images.emplace(std::move(*compared));
  }
  progress.close();
  return publish(o, {context, *report, images ? &*images : nullptr, pictures ? &*pictures : nullptr});
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
