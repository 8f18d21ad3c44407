#include "apps/audit/report.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace tintree::audit {
namespace {

constexpr std::size_t kPrinted = 10;
constexpr std::size_t kInJson = 1000;

/// Null for what concerns the file as a whole.
nlohmann::ordered_json tile_json(const Violation& v) {
  return v.tile ? nlohmann::ordered_json(v.tile->text()) : nlohmann::ordered_json();
}

nlohmann::ordered_json level_json(const LevelReport& l) {
  return {{"level", l.level},
          {"tiles", l.tiles},
          {"vertices", l.vertices},
          {"triangles", l.triangles},
          {"bytes", l.bytes},
          {"bound_m", l.bound_m},
          {"vertical_max_m", l.vertical_max_m},
          {"vertical_rms_m", l.vertical_rms_m},
          {"vertical_p999_m", l.vertical_p999_m},
          {"border_max_m", l.border_max_m},
          {"gap_max_m", l.gap_max_m},
          {"gap_max_px", l.gap_max_px},
          {"samples", l.samples},
          {"seconds", l.seconds},
          {"violations", l.violations}};
}

template <typename Out>
void put_views(Out to, const ImageReport& images) {
  for (const ViewReport& v : images.views) {
    fmt::format_to(to,
                   "view {}: {} tiles, {} triangles, off by at most {:.3f} pixels ({:.3f} as drawn) where {:.3f} are "
                   "allowed, {} crack and {} outline pixels{}\n",
                   v.name, v.tiles, v.triangles, v.shift_max_px, v.drawn_max_px, v.limit_px, v.crack_px,
                   v.silhouette_px, v.amiss_px == 0 ? "" : fmt::format(", {} drawn amiss by the driver", v.amiss_px));
  }
}

nlohmann::ordered_json views_json(const ImageReport& images) {
  auto views = nlohmann::ordered_json::array();
  for (const ViewReport& v : images.views) {
    views.push_back({{"view", v.name},
                     {"eye_m", v.eye_m},
                     {"target_m", v.target_m},
                     {"width_px", images.width_px},
                     {"height_px", images.height_px},
                     {"tiles", v.tiles},
                     {"triangles", v.triangles},
                     {"limit_px", v.limit_px},
                     {"shift_max_px", v.shift_max_px},
                     {"shift_rms_px", v.shift_rms_px},
                     {"distance_max_px", v.distance_max_px},
                     {"drawn_max_px", v.drawn_max_px},
                     {"amiss_px", v.amiss_px},
                     {"crack_px", v.crack_px},
                     {"silhouette_px", v.silhouette_px},
                     {"terrain_px", v.terrain_px}});
  }
  return views;
}

}  // namespace

std::vector<Violation> by_severity(const TreeReport& report) {
  std::vector<Violation> sorted = report.violations;
  std::ranges::stable_sort(sorted, std::ranges::greater{}, &Violation::severity);
  return sorted;
}

std::string report_text(const TreeReport& report, const ImageReport* images, const PictureReport* pictures) {
  std::string out = fmt::format("{:>5} {:>7} {:>10} {:>10} {:>12} {:>9} {:>10} {:>10} {:>10} {:>10} {:>6} {:>10}\n",
                                "level", "tiles", "triangles", "bound m", "vertical max", "max/bound", "rms m",
                                "99.9 % m", "border max", "gap m", "gap px", "violations");
  auto to = std::back_inserter(out);
  for (const LevelReport& l : report.levels) {
    fmt::format_to(
        to, "{:>5} {:>7} {:>10} {:>10.6g} {:>12.6g} {:>9.4f} {:>10.5g} {:>10.5g} {:>10.5g} {:>10.5g} {:>6.3f} {:>10}\n",
        l.level, l.tiles, l.triangles, l.bound_m, l.vertical_max_m, l.vertical_max_m / l.bound_m, l.vertical_rms_m,
        l.vertical_p999_m, l.border_max_m, l.gap_max_m, l.gap_max_px, l.violations);
  }
  for (const HausdorffReport& h : report.hausdorff) {
    fmt::format_to(to,
                   "CGAL, tile {}, columns {}-{}, rows {}-{}: Hausdorff distance {:.6g} m (+- {:.2g}), vertical "
                   "maximum {:.6g} m\n",
                   h.tile.text(), h.cells.column0, h.cells.column1, h.cells.row0, h.cells.row1, h.hausdorff_m,
                   h.error_bound_m, h.vertical_max_m);
  }
  if (pictures != nullptr) {
    fmt::format_to(to, "{} textures", pictures->textures);
    if (pictures->photo_rms > 0)
      fmt::format_to(to, ", the finest {:.2f} steps of 255 off the photo (RMS)", pictures->photo_rms);
    fmt::format_to(to, "; {} normal maps", pictures->normal_maps);
    if (pictures->normal_rms > 0)
      fmt::format_to(to, ", the leaves' {:.4f} off the DEM's normals (RMS)", pictures->normal_rms);
    fmt::format_to(to, "\n");
  }
  if (images != nullptr) put_views(to, *images);
  fmt::format_to(to, "{:.1f} s, {:.1f} million samples a second\n", report.seconds, report.samples_per_second / 1e6);
  const std::vector<Violation> sorted = by_severity(report);
  for (std::size_t i = 0; i < std::min(kPrinted, sorted.size()); ++i) fmt::format_to(to, "{}\n", sorted[i].text());
  if (sorted.size() > kPrinted) fmt::format_to(to, "... and {} more (--json lists them)\n", sorted.size() - kPrinted);
  return out;
}

std::string verdict(const TreeReport& report) {
  if (const Violation* worst = report.worst()) {
    const std::size_t n = report.violations.size();
    return fmt::format("FAIL: {} violation{}; worst: {}", n, n == 1 ? "" : "s", worst->text());
  }
  std::uint64_t tiles = 0;
  double ratio = 0;
  for (const LevelReport& l : report.levels) {
    tiles += l.tiles;
    ratio = std::max(ratio, l.vertical_max_m / l.bound_m);
  }
  return fmt::format("PASS: all {} tiles of {} levels keep their bounds; the largest error is {:.2f} % of its bound",
                     tiles, report.levels.size(), 100 * ratio);
}

nlohmann::ordered_json report_json(const TreeReport& report, const ImageReport* images, const PictureReport* pictures) {
  nlohmann::ordered_json json;
  json["verdict"] = report.violations.empty() ? "pass" : "fail";
  json["violations"] = report.violations.size();
  const Violation* worst = report.worst();
  json["worst_tile"] = worst == nullptr ? nlohmann::ordered_json() : tile_json(*worst);
  json["levels"] = nlohmann::ordered_json::array();
  for (const LevelReport& l : report.levels) json["levels"].push_back(level_json(l));
  json["hausdorff"] = nlohmann::ordered_json::array();
  for (const HausdorffReport& h : report.hausdorff) {
    json["hausdorff"].push_back({{"tile", h.tile.text()},
                                 {"columns", {h.cells.column0, h.cells.column1}},
                                 {"rows", {h.cells.row0, h.cells.row1}},
                                 {"hausdorff_m", h.hausdorff_m},
                                 {"error_bound_m", h.error_bound_m},
                                 {"vertical_max_m", h.vertical_max_m}});
  }
  if (pictures != nullptr) {
    json["textures"] = pictures->textures;
    json["texture_rms"] = pictures->photo_rms;
    json["normal_maps"] = pictures->normal_maps;
    json["normal_rms"] = pictures->normal_rms;
  }
  if (images != nullptr) json["views"] = views_json(*images);
  json["violation_list"] = nlohmann::ordered_json::array();
  const std::vector<Violation> sorted = by_severity(report);
  for (std::size_t i = 0; i < std::min(kInJson, sorted.size()); ++i) {
    json["violation_list"].push_back(
        {{"tile", tile_json(sorted[i])}, {"kind", kind_name(sorted[i].kind)}, {"message", sorted[i].message}});
  }
  json["seconds"] = report.seconds;
  json["samples_per_second"] = report.samples_per_second;
  return json;
}

}  // namespace tintree::audit
