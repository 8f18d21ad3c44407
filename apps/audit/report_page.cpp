#include "apps/audit/report_page.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "apps/audit/color_scale.h"
#include "apps/audit/report.h"
#include "apps/audit/report_charts.h"
#include "apps/audit/report_checks.h"
#include "apps/audit/report_pictures.h"
#include "apps/audit/report_style.h"
#include "apps/audit/report_text.h"

namespace tintree::audit {
namespace {

struct Totals {
  std::uint64_t tiles = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  double ratio = 0;
};

Totals totals_of(const TreeReport& tree) {
  Totals t;
  for (const LevelReport& l : tree.levels) {
    t.tiles += l.tiles;
    t.triangles += l.triangles;
    t.bytes += l.bytes;
    t.ratio = std::max(t.ratio, l.vertical_max_m / l.bound_m);
  }
  return t;
}

std::string base_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

std::string plain_verdict(const ReportInput& input, const Totals& totals) {
  const TreeReport& tree = input.tree;
  if (const Violation* worst = tree.worst()) {
    return fmt::format("{} violation{} found. The worst: {}.", grouped(tree.violations.size()),
                       tree.violations.size() == 1 ? " was" : "s were", escape_html(worst->text()));
  }
  const LevelReport& leaves = tree.levels.back();
  return fmt::format(
      "Every point of all {} tiles on {} level{} lies within its level&rsquo;s bound of the elevation model. At full "
      "detail "
      "the largest error is {}&nbsp;m of the {}&nbsp;m promised, and {}&nbsp;m at 99.9 % of the samples.",
      grouped(totals.tiles), tree.levels.size(), tree.levels.size() == 1 ? "" : "s", metres(leaves.vertical_max_m),
      metres(leaves.bound_m), metres(leaves.vertical_p999_m));
}

void put_head(std::string& out, const ReportInput& input) {
  const std::string name = escape_html(base_name(input.context.store.path()));
  fmt::format_to(std::back_inserter(out),
                 R"(<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">)"
                 R"(<meta name="viewport" content="width=device-width, initial-scale=1"><title>Audit of {}</title>)"
                 "\n<style>{}</style></head><body><main>\n",
                 name, kReportStyle);
}

void put_verdict(std::string& out, const ReportInput& input) {
  const Totals totals = totals_of(input.tree);
  const bool pass = input.tree.violations.empty();
  auto to = std::back_inserter(out);
  fmt::format_to(to, "<h1>Accuracy audit of {} against {}</h1>\n", escape_html(base_name(input.context.store.path())),
                 escape_html(base_name(input.context.source.info().path)));
  fmt::format_to(to, R"(<div class="verdict{}"><strong>{}</strong><p>{}</p></div>)", pass ? "" : " fail",
                 pass ? "&#10003; Pass" : "&#10007; Fail", plain_verdict(input, totals));
  const LevelReport& leaves = input.tree.levels.back();
  const auto samples = static_cast<double>(std::max<std::uint64_t>(leaves.samples, 1));
  out += "\n<div class=\"facts\">";
  const auto fact = [&to](const std::string& value, const char* name) {
    fmt::format_to(to, "<div><b>{}</b><span>{}</span></div>", value, name);
  };
  fact(share_text(totals.ratio), "of its bound: the largest error");
  fact(metres(leaves.vertical_rms_m) + " m", "RMS error at full detail");
  fact(grouped(leaves.samples), "samples compared at full detail");
  fact(grouped(totals.triangles), "triangles on all levels");
  fact(fmt::format("{:.3g}", 8 * static_cast<double>(totals.bytes) / samples), "bits a sample, all levels");
  out += "</div>\n";
}

void put_levels(std::string& out, const TreeReport& tree) {
  auto to = std::back_inserter(out);
  out +=
      R"(<h2>Levels</h2><p>Level 0 is the root, the last one full detail. All distances are vertical and in metres, against the
surface through the DEM&rsquo;s samples.</p><div class="scroll"><table><tr><th>Level</th><th>Tiles</th><th>Triangles</th><th>Bound</th>
<th>Largest</th><th>of bound</th><th>99.9 %</th><th>RMS</th><th>Largest<br>on borders</th><th>Gap to next<br>coarser</th>
<th>Gap,<br>pixels</th><th>Violations</th></tr>)";
  for (const LevelReport& l : tree.levels) {
    fmt::format_to(to, "\n<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
                   l.level, grouped(l.tiles), grouped(l.triangles), metres(l.bound_m), metres(l.vertical_max_m),
                   share_text(l.vertical_max_m / l.bound_m), metres(l.vertical_p999_m), metres(l.vertical_rms_m));
    fmt::format_to(to, "<td>{}</td><td>{}</td><td>{:.3f}</td><td class=\"{}\">{}</td></tr>", metres(l.border_max_m),
                   metres(l.gap_max_m), l.gap_max_px, l.violations == 0 ? "ok" : "bad", grouped(l.violations));
  }
  out +=
      R"(</table></div><p class="note">Gap in pixels: to a neighbour of any coarser level, at the shortest distance at which a viewer
with a pixel error of 1 draws both.</p>)";
}

void put_histograms(std::string& out, const TreeReport& tree) {
  out +=
      R"(<h2>How errors spread</h2><p>Share of a level&rsquo;s samples by their error, as a part of the level&rsquo;s bound. Nothing
lies right of 100 %, unless the verdict says so.</p><div class="grid">)";
  for (const LevelReport& l : tree.levels) {
    const std::string beyond =
        l.histogram.beyond() > 0 ? ", <b>" + grouped(l.histogram.beyond()) + " samples beyond it</b>" : "";
    fmt::format_to(std::back_inserter(out),
                   "\n<figure><h3>Level {}, bound {} m</h3>{}<figcaption>{} samples{}</figcaption></figure>", l.level,
                   metres(l.bound_m), histogram_svg(l), grouped(l.samples), beyond);
  }
  out += "</div>\n";
}

void put_sizes(std::string& out, const ReportInput& input) {
  const Totals totals = totals_of(input.tree);
  auto to = std::back_inserter(out);
  out += R"(<h2>Sizes</h2><div class="scroll"><table><tr><th>Level</th><th>Tiles</th><th>Vertices</th><th>Triangles</th>
<th>Payload</th><th>Bits a vertex</th><th>Bits a sample</th><th class="text">Share of the payload</th></tr>)";
  for (const LevelReport& l : input.tree.levels) {
    const double bits = 8 * static_cast<double>(l.bytes);
    fmt::format_to(
        to,
        "\n<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.1f}</td><td>{:.4f}</td><td "
        "class=\"text\">{}</td></tr>",
        l.level, grouped(l.tiles), grouped(l.vertices), grouped(l.triangles), bytes_text(l.bytes),
        bits / static_cast<double>(std::max<std::uint64_t>(l.vertices, 1)),
        bits / static_cast<double>(std::max<std::uint64_t>(l.samples, 1)),
        bar_svg(static_cast<double>(l.bytes) / static_cast<double>(std::max<std::uint64_t>(totals.bytes, 1))));
  }
  out += "</table></div>\n";
}

void put_hausdorff(std::string& out, const TreeReport& tree) {
  if (tree.hausdorff.empty()) return;
  auto to = std::back_inserter(out);
  out +=
      R"(<h2>An outside yardstick</h2><p>CGAL&rsquo;s symmetric Hausdorff distance between tile and surface in sampled windows, within
CGAL&rsquo;s own error. It never exceeds the vertical maximum: on steep ground it is smaller.</p><div class="scroll">
<table><tr><th class="text">Tile</th><th>Columns</th><th>Rows</th><th>Hausdorff, m</th><th>CGAL&rsquo;s error, m</th>
<th>Vertical maximum, m</th></tr>)";
  for (const HausdorffReport& h : tree.hausdorff) {
    fmt::format_to(
        to,
        "\n<tr><td "
        "class=\"text\">{}</td><td>{}&ndash;{}</td><td>{}&ndash;{}</td><td>{}</td><td>{:.2g}</td><td>{}</td></tr>",
        h.tile.text(), h.cells.column0, h.cells.column1, h.cells.row0, h.cells.row1, metres(h.hausdorff_m),
        h.error_bound_m, metres(h.vertical_max_m));
  }
  out += "</table></div>\n";
}

void put_provenance(std::string& out, const ReportInput& input) {
  const cache::Manifest& m = input.context.store.manifest();
  const cache::RasterInfo& dem = input.context.source.info();
  auto to = std::back_inserter(out);
  out += "<h2>What was compared</h2><dl>";
  const auto row = [&to](const char* name, const std::string& value) {
    fmt::format_to(to, "<dt>{}</dt><dd>{}</dd>\n", name, value);
  };
  row("Tree", escape_html(input.context.store.path()));
  row("Digest of its tiles", "<code>" + escape_html(m.digest) + "</code>");
  row("Method", escape_html(m.method));
  for (const cache::InputFile& input_file : dem.inputs) row("DEM", escape_html(input_file.path));
  row("Digest of its heights", "<code>" + escape_html(m.samples_digest) + "</code>");
  row("Samples", fmt::format("{} &times; {}, {} &times; {} m apart", grouped(static_cast<std::uint64_t>(dem.columns)),
                             grouped(static_cast<std::uint64_t>(dem.rows)), metres(dem.dx_m), metres(dem.dy_m)));
  row("Samples without a height", m.nodata == cache::NodataPolicy::kFill ? "filled" : "left out");
  row("Leaf tiles", fmt::format("{0} &times; {0} cells", m.layout.tile_cells));
  row("Textures and normal maps", "none in this file");
  row("Time", fmt::format("{:.1f} s, {:.1f} million samples a second", input.tree.seconds,
                          input.tree.samples_per_second / 1e6));
  out += "</dl>\n";
}

}  // namespace

Expected<std::string> report_page(const ReportInput& input) {
  std::string out;
  put_head(out, input);
  put_verdict(out, input);
  out += "<h2>What was checked</h2>" + checks_table(input) + violations_table(input.tree);
  put_levels(out, input.tree);
  put_histograms(out, input.tree);
  if (auto put = put_maps(out, input); !put) return tl::unexpected(put.error());
  if (auto put = put_worst_tiles(out, input); !put) return tl::unexpected(put.error());
  if (auto put = put_views(out, input); !put) return tl::unexpected(put.error());
  put_sizes(out, input);
  put_hausdorff(out, input.tree);
  put_provenance(out, input);
  return out + "</main></body></html>\n";
}

}  // namespace tintree::audit
