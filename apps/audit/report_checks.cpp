#include "apps/audit/report_checks.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "apps/audit/report.h"
#include "apps/audit/report_text.h"

namespace tintree::audit {
namespace {

constexpr std::size_t kListed = 20;

using enum ViolationKind;

struct Check {
  const char* name;
  const char* what;
  std::vector<ViolationKind> kinds;
  const char* not_run = nullptr;  ///< Why it was left out.
};

std::vector<Check> all_checks(const ReportInput& input) {
  return {
      {"Geometry",
       "The vertical distance stays within the level's bound at every point: samples, vertices and all "
       "crossings of mesh edges with the grid",
       {kBound}},
      {"Stored figures",
       "Largest error, RMS, border error, height range and counts are those measured here",
       {kStoredFigure}},
      {"Topology", "Every mesh is a manifold, no triangle flipped, degenerate or twice", {kTopology}},
      {"Coverage",
       "Every valid cell of the DEM is covered exactly once on every level; holes are exactly where data are missing",
       {kCoverage, kMissingTile, kExtraTile}},
      {"Borders", "Neighbours of one level have the same vertices on their common side, bit for bit", {kBorder}},
      {"Gaps", "Neighbours of two levels open no gap wider than a pixel where a viewer may draw both", {kGap}},
      {"File", "Checksums hold, every tile decodes, the table names the hierarchy's tiles", {kFile}},
      {"Digests", "The manifest's digests are those of the tiles and of the DEM given", {kManifest}},
      {"Boxes", "Every box holds its tile and lies inside its parent's; its error is not understated", {kHierarchy}},
      {"Hausdorff",
       "CGAL's symmetric Hausdorff distance on sampled windows is at most the vertical maximum",
       {kHausdorff},
       input.tree.hausdorff.empty() ? "not asked for" : nullptr},
      {"Textures and normal maps",
       "They decode, lie where the photo, the DEM and their children lie, and show the same",
       {kPicture},
       input.pictures == nullptr ? "the tree has none" : nullptr},
      {"Pictures",
       "Pictures drawn from the tree equal the full-resolution surface within the pixel error, without cracks",
       {kImage},
       input.images == nullptr ? "not asked for (--images)" : nullptr},
  };
}

std::string result_cell(const Check& check, const TreeReport& report) {
  const auto found = std::ranges::count_if(report.violations, [&check](const Violation& v) {
    return std::ranges::find(check.kinds, v.kind) != check.kinds.end();
  });
  if (found > 0) return fmt::format(R"(<td class="bad">&#10007; {}</td>)", grouped(static_cast<std::uint64_t>(found)));
  if (check.not_run != nullptr) return fmt::format(R"(<td class="off">{}</td>)", check.not_run);
  return R"(<td class="ok">&#10003; holds</td>)";
}

}  // namespace

std::string checks_table(const ReportInput& input) {
  std::string out = R"(<table class="checks"><tr><th class="text">Check</th><th class="text">What must hold</th>)"
                    "<th>Result</th></tr>\n";
  for (const Check& check : all_checks(input)) {
    fmt::format_to(std::back_inserter(out), R"(<tr><td class="text">{}</td><td class="text">{}</td>{}</tr>)",
                   check.name, check.what, result_cell(check, input.tree));
    out += '\n';
  }
  return out + "</table>\n";
}

std::string violations_table(const TreeReport& report) {
  if (report.violations.empty()) return {};
  const std::vector<Violation> sorted = by_severity(report);
  std::string out =
      R"(<h2 id="violations">Violations</h2><table><tr><th class="text">Where</th><th class="text">Kind</th>)"
      R"(<th class="text">What</th></tr>)";
  for (std::size_t i = 0; i < std::min(kListed, sorted.size()); ++i) {
    const Violation& v = sorted[i];
    fmt::format_to(std::back_inserter(out),
                   R"(<tr><td class="text">{}</td><td class="text">{}</td><td class="text">{}</td></tr>)",
                   v.tile ? "tile&nbsp;" + v.tile->text() : "the file", kind_name(v.kind), escape_html(v.message));
  }
  out += "</table>\n";
  if (sorted.size() > kListed) {
    out += fmt::format(R"(<p class="note">and {} more; the JSON output lists the worst 1000.</p>)",
                       grouped(sorted.size() - kListed));
  }
  return out;
}

}  // namespace tintree::audit
