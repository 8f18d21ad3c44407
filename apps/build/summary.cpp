#include "apps/build/summary.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/common/json_file.h"

namespace tintree::app {
namespace {

double bits_per(std::uint64_t bytes, std::uint64_t units) {
  return units == 0 ? 0 : 8.0 * static_cast<double>(bytes) / static_cast<double>(units);
}

simplify::LevelSummary total_of(const BuildReport& report) {
  simplify::LevelSummary total;
  for (const simplify::LevelSummary& l : report.levels) {
    total.tiles += l.tiles;
    total.tiles_made += l.tiles_made;
    total.vertices += l.vertices;
    total.triangles += l.triangles;
    total.bytes += l.bytes;
    total.make_seconds += l.make_seconds;
  }
  return total;
}

/// A line on one kind of pictures, nothing where there are none.
std::string picture_line(const char* name, int size, const auto& pictures) {
  if (pictures.pictures == 0) return {};
  return fmt::format("{} {} of {} x {} texels: {} bytes, {:.2f} thread s\n", pictures.pictures, name, size, size,
                     pictures.bytes, pictures.make_seconds);
}

nlohmann::ordered_json picture_json(const auto& pictures) {
  return {{"pictures", pictures.pictures}, {"bytes", pictures.bytes}, {"thread_seconds", pictures.make_seconds}};
}

}  // namespace

std::string summary_text(const BuildReport& report, const std::string& output) {
  std::string out =
      fmt::format("{:>5} {:>8} {:>11} {:>11} {:>12} {:>8} {:>11} {:>11} {:>6} {:>9}\n", "level", "tiles", "vertices",
                  "triangles", "bytes", "bits/v", "bound m", "measured m", "ratio", "thread s");
  const auto line = [&out](const std::string& name, const simplify::LevelSummary& l, const std::string& errors) {
    fmt::format_to(std::back_inserter(out), "{:>5} {:>8} {:>11} {:>11} {:>12} {:>8.2f} {:>30} {:>9.2f}\n", name,
                   l.tiles, l.vertices, l.triangles, l.bytes, bits_per(l.bytes, l.vertices), errors, l.make_seconds);
  };
  for (const simplify::LevelSummary& l : report.levels) {
    line(std::to_string(l.level), l,
         fmt::format("{:>11.5g} {:>11.5g} {:>6.3f}", l.bound_m, l.error_m, l.error_m / l.bound_m));
  }
  const simplify::LevelSummary total = total_of(report);
  line("all", total, "");
  const int depth = report.manifest.texture_depth;
  const std::string textures =
      depth > 0 ? fmt::format("textures, down to 1/{} of a leaf's side,", 1 << depth) : std::string("textures");
  out += picture_line(textures.c_str(), report.manifest.picture_size(cache::PictureKind::kTexture), report.textures);
  out += picture_line("normal maps", report.manifest.picture_size(cache::PictureKind::kNormal), report.normals);
  fmt::format_to(std::back_inserter(out),
                 "{} samples in {:.1f} s ({:.2f} M samples/s on {} threads: read {:.1f}, make {:.1f}, pictures {:.1f}, "
                 "measure {:.1f}), "
                 "peak memory {:.0f} MiB\n",
                 report.samples, report.seconds, static_cast<double>(report.samples) / report.seconds / 1e6,
                 report.threads, report.read_seconds, report.make_seconds, report.picture_seconds,
                 report.measure_seconds, static_cast<double>(peak_rss_bytes()) / (1 << 20));
  fmt::format_to(std::back_inserter(out), "{}: {} bytes; {:.4f} bits per sample (whole file {:.4f})\ndigest {}\n",
                 output, report.file_bytes, bits_per(total.bytes, report.samples),
                 bits_per(report.file_bytes, report.samples), report.manifest.digest);
  return out;
}

std::string plan_text(const TreePlan& plan) {
  std::string out = fmt::format("{:>5} {:>8} {:>8} {:>11} {:>11} {:>12} {:>11} {:>9}\n", "level", "tiles", "sampled",
                                "vertices", "triangles", "bytes", "bound m", "thread s");
  const auto line = [&out](const std::string& name, const simplify::LevelSummary& l, std::uint64_t sampled,
                           const std::string& bound) {
    fmt::format_to(std::back_inserter(out), "{:>5} {:>8} {:>8} {:>11} {:>11} {:>12} {:>11} {:>9.2f}\n", name, l.tiles,
                   sampled, l.vertices, l.triangles, l.bytes, bound, l.make_seconds);
  };
  std::uint64_t sampled = 0;
  for (const TreePlan::Level& l : plan.levels) {
    line(std::to_string(l.estimate.level), l.estimate, l.sampled, fmt::format("{:.5g}", l.estimate.bound_m));
    sampled += l.sampled;
  }
  line("all", plan.total, sampled, "");
  fmt::format_to(std::back_inserter(out),
                 "a file of about {:.3g} MiB, in about {:.3g} s on {} threads (read {:.1f}, make {:.1f}, measure "
                 "{:.1f}), with about {:.0f} MiB of memory\n"
                 "judged by a sample in {:.1f} s; nothing was written\n",
                 static_cast<double>(plan.bytes) / (1 << 20), plan.seconds, plan.threads, plan.read_seconds,
                 plan.make_seconds, plan.measure_seconds, static_cast<double>(plan.peak_rss_bytes) / (1 << 20),
                 plan.plan_seconds);
  if (plan.textures.pictures + plan.normals.pictures > 0) {
    fmt::format_to(std::back_inserter(out), "with about {} textures, {:.3g} MiB, and {} normal maps, {:.3g} MiB\n",
                   plan.textures.pictures, static_cast<double>(plan.textures.bytes) / (1 << 20), plan.normals.pictures,
                   static_cast<double>(plan.normals.bytes) / (1 << 20));
  }
  return out;
}

nlohmann::ordered_json plan_json(const TreePlan& plan, const BuildOptions& options) {
  using nlohmann::ordered_json;
  ordered_json levels = ordered_json::array();
  for (const TreePlan::Level& l : plan.levels) {
    levels.push_back({{"level", l.estimate.level},
                      {"tiles", l.estimate.tiles},
                      {"tiles_sampled", l.sampled},
                      {"vertices", l.estimate.vertices},
                      {"triangles", l.estimate.triangles},
                      {"bytes", l.estimate.bytes},
                      {"bound_m", l.estimate.bound_m},
                      {"thread_seconds", l.estimate.make_seconds}});
  }
  return {{"plan", true},
          {"plan_seconds", plan.plan_seconds},
          {"seconds", plan.seconds},
          {"read_seconds", plan.read_seconds},
          {"make_seconds", plan.make_seconds},
          {"picture_seconds", plan.picture_seconds},
          {"measure_seconds", plan.measure_seconds},
          {"thread_seconds", plan.total.make_seconds},
          {"threads", plan.threads},
          {"samples", plan.samples},
          {"peak_rss_bytes", plan.peak_rss_bytes},
          {"error_m", plan.levels.back().estimate.bound_m},
          {"method", options.method},
          {"effort", options.effort},
          {"tile_cells", options.tile_cells},
          {"levels_per_doubling", options.levels_per_doubling},
          {"tiles", plan.total.tiles},
          {"vertices", plan.total.vertices},
          {"triangles", plan.total.triangles},
          {"payload_bytes", plan.total.bytes},
          {"texture_depth", plan.texture_depth},
          {"textures", picture_json(plan.textures)},
          {"normal_maps", picture_json(plan.normals)},
          {"bytes", plan.bytes},
          {"levels", levels}};
}

nlohmann::ordered_json summary_json(const BuildReport& report) {
  using nlohmann::ordered_json;
  const simplify::LevelSummary total = total_of(report);
  ordered_json levels = ordered_json::array();
  double error_m = 0;
  for (const simplify::LevelSummary& l : report.levels) {
    levels.push_back({{"level", l.level},
                      {"tiles", l.tiles},
                      {"vertices", l.vertices},
                      {"triangles", l.triangles},
                      {"bytes", l.bytes},
                      {"bits_per_vertex", bits_per(l.bytes, l.vertices)},
                      {"bound_m", l.bound_m},
                      {"vertical_max_m", l.error_m},
                      {"vertical_rms_m", l.rms_m},
                      {"thread_seconds", l.make_seconds}});
    error_m = std::max(error_m, l.error_m);
  }
  return {{"seconds", report.seconds},
          {"read_seconds", report.read_seconds},
          {"make_seconds", report.make_seconds},
          {"picture_seconds", report.picture_seconds},
          {"measure_seconds", report.measure_seconds},
          {"threads", report.threads},
          {"samples", report.samples},
          {"valid_samples", report.valid_samples},
          {"samples_per_second", static_cast<double>(report.samples) / report.seconds},
          {"peak_rss_bytes", peak_rss_bytes()},
          {"error_m", report.manifest.layout.leaf_error_m},
          {"method", report.manifest.method},
          {"effort", report.manifest.effort},
          {"tile_cells", report.manifest.layout.tile_cells},
          {"levels_per_doubling", report.manifest.layout.levels_per_doubling},
          {"tiles", total.tiles},
          {"tiles_made", total.tiles_made},
          {"vertices", total.vertices},
          {"triangles", total.triangles},
          {"payload_bytes", total.bytes},
          {"texture_size", report.manifest.texture_size},
          {"texture_depth", report.manifest.texture_depth},
          {"textures", picture_json(report.textures)},
          {"textures_made", report.textures.made},
          {"normal_maps", picture_json(report.normals)},
          {"normal_maps_made", report.normals.made},
          {"bytes", report.file_bytes},
          {"bits_per_sample", bits_per(total.bytes, report.samples)},
          {"file_bits_per_sample", bits_per(report.file_bytes, report.samples)},
          {"digest", report.manifest.digest},
          {"levels", levels}};
}

}  // namespace tintree::app
