#include "apps/audit/report_pictures.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/audit/color_scale.h"
#include "apps/audit/report_text.h"
#include "apps/audit/shaded_relief.h"
#include "apps/audit/tile_picture.h"

namespace tintree::audit {
namespace {

constexpr int kReliefPx = 512;
constexpr int kTilePx = 256;
constexpr std::size_t kShownViews = 4;

std::string legend(const std::string& end) {
  const auto color = [](const Rgb& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); };
  return fmt::format(
      R"(<div class="legend"><span>0</span><span class="scale" style="background:{}"></span><span>{}</span>)"
      R"(<span class="swatch" style="background:{}"></span><span>beyond it</span>)"
      R"(<span class="swatch" style="background:{}"></span><span>no surface</span></div>)",
      scale_css(), end, color(kBeyond), color(kNoSurface));
}

Expected<void> put_figure(std::string& out, const app::RgbImage& image, const std::string& title,
                          const std::string& caption) {
  const auto uri = app::png_data_uri(image);
  if (!uri) return tl::unexpected(uri.error());
  fmt::format_to(
      std::back_inserter(out),
      R"(<figure><h3>{0}</h3><img src="{2}" width="{3}" height="{4}" alt="{0}"><figcaption>{1}</figcaption></figure>)",
      title, caption, *uri, image.width_px, image.height_px);
  out += '\n';
  return {};
}

/// A picture with a ring round the largest error.
std::string shot(const std::string& uri, const TilePictures& p, const std::string& caption) {
  if (uri.empty()) return "<figure><figcaption>The tile cannot be read.</figcaption></figure>";
  return fmt::format(
      R"(<figure><span class="shot"><img src="{0}" width="{1}" height="{2}" alt="{3}"><svg viewBox="0 0 {1} {2}" )"
      R"(preserveAspectRatio="none"><circle cx="{4:.1f}" cy="{5:.1f}" r="{6:.1f}"/><circle cx="{4:.1f}" cy="{5:.1f}" )"
      R"(r="{6:.1f}"/></svg></span><figcaption>{3}</figcaption></figure>)",
      uri, p.width_px, p.height_px, caption, p.peak_x_px + 0.5, p.peak_y_px + 0.5, 0.035 * p.width_px);
}

std::string describe(const TileFigures& t) {
  return fmt::format(
      R"(<h3>Tile {}</h3><p>Largest error {} m, {} of the bound of {} m, at column {:.1f}, row {:.1f} of the DEM; 99.9 % of its
samples {} m, RMS {} m. {} triangles, {}.</p>)",
      t.id.text(), metres(t.peak.value_m), share_text(t.peak.value_m / t.bound_m), metres(t.bound_m), t.peak.column,
      t.peak.row, metres(t.p999_m), metres(t.rms_m), grouped(t.triangles), bytes_text(t.bytes));
}

/// Those to be shown: with cracks first, then by shift.
std::vector<const ViewReport*> worst_views(const ImageReport& images) {
  std::vector<const ViewReport*> views;
  for (const ViewReport& v : images.views) views.push_back(&v);
  std::ranges::stable_sort(views, std::ranges::greater{}, [](const ViewReport* v) {
    return std::pair(v->crack_px + v->silhouette_px, std::max(v->shift_max_px, v->drawn_max_px) / v->limit_px);
  });
  views.resize(std::min(views.size(), kShownViews));
  return views;
}

}  // namespace

Expected<void> put_maps(std::string& out, const ReportInput& input) {
  const codec::TreeLayout& layout = input.context.store.manifest().layout;
  out +=
      "<h2>Where the errors are</h2><p>Largest error under each pixel, as a part of the level&rsquo;s bound. North is "
      "up.</p>";
  out += legend("the level&rsquo;s bound") + "<div class=\"grid\">";
  const auto dem = picture_of_dem(input.context.source, {0, 0, layout.columns - 1, layout.rows - 1}, kReliefPx);
  if (!dem) return tl::unexpected(dem.error());
  const double gain = relief_gain(*dem, layout);
  auto put = put_figure(out, shade(*dem, layout, gain), "The terrain",
                        gain > 1.05 ? fmt::format("Shaded, heights &times; {:.2g}", gain) : "Shaded");
  if (!put) return put;
  for (const LevelReport& l : input.tree.levels) {
    if (l.map == nullptr) continue;
    put = put_figure(out, draw_map(*l.map, l.bound_m), fmt::format("Level {}", l.level),
                     fmt::format("Bound {} m, largest error {} m", metres(l.bound_m), metres(l.vertical_max_m)));
    if (!put) return put;
  }
  out += "</div>\n";
  return {};
}

Expected<void> put_worst_tiles(std::string& out, const ReportInput& input) {
  if (input.tree.worst_tiles.empty()) return {};
  out +=
      "<h2>The worst tiles</h2><p>Those with violations first, then those that come nearest to their bound. The ring "
      "marks the "
      "largest error.</p>";
  out += legend("the tile&rsquo;s bound");
  for (const TileFigures& t : input.tree.worst_tiles) {
    const auto pictures = draw_tile(input.context, t, kTilePx);
    if (!pictures) return tl::unexpected(pictures.error());
    out += R"(<section class="tile">)" + describe(t) + R"(<div class="triple">)";
    out += shot(pictures->dem, *pictures, "The DEM, shaded");
    out += shot(pictures->mesh, *pictures, "The tile&rsquo;s mesh, shaded the same");
    out += shot(pictures->errors, *pictures, "Measured error");
    out += "</div></section>\n";
  }
  return {};
}

Expected<void> put_views(std::string& out, const ReportInput& input) {
  if (input.images == nullptr) return {};
  const ImageReport& images = *input.images;
  auto to = std::back_inserter(out);
  fmt::format_to(
      to,
      R"(<h2>Pictures</h2><p>{} views of {}&thinsp;&times;&thinsp;{} pixels, drawn with a pixel error of {:g} and compared
pixel by pixel with the full-resolution surface. <i>Shift</i>: how far the surface&rsquo;s point seen at a pixel lies from the drawn mesh, on
the screen. <i>Distance</i>: the same in space, over the pixel&rsquo;s footprint.
<i>Drawn</i>: the shift from the drawn point to the surface. <i>Amiss</i>: the driver drew a point that is on no mesh (a triangle seen edge-on); the mesh&rsquo;s exact one counts. <i>Cracks</i>: background seen through the terrain. <i>Outline</i>: terrain drawn more than a pixel outside the surface&rsquo;s outline. Driver: {}.</p>)",
      images.views.size(), images.width_px, images.height_px, images.pixel_error, escape_html(images.renderer));
  out +=
      R"(<div class="scroll"><table><tr><th class="text">View</th><th>Tiles</th><th>Triangles</th><th>Allowed, px</th>
<th>Shift, px</th><th>RMS, px</th><th>Distance, px</th><th>Drawn, px</th><th>Amiss, px</th><th>Cracks, px</th><th>Outline, px</th><th>Terrain, px</th></tr>)";
  for (const ViewReport& v : images.views) {
    fmt::format_to(to,
                   "\n<tr><td "
                   "class=\"text\">{}</td><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.3f}</td><td>{:.3f}</"
                   "td><td>{:.3f}</td><td>{:.3f}</td>",
                   v.name, v.tiles, grouped(v.triangles), v.limit_px, v.shift_max_px, v.shift_rms_px, v.distance_max_px,
                   v.drawn_max_px);
    fmt::format_to(to, "<td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>", v.amiss_px, v.crack_px, v.silhouette_px,
                   grouped(v.terrain_px));
  }
  out += "</table></div>" + legend("the shift allowed") +
         "<p class=\"note\">Pictures of the views with the largest shifts.</p><div class=\"grid views\">";
  for (const ViewReport* v : worst_views(images)) {
    if (auto put = put_figure(out, v->picture, v->name, "As drawn"); !put) return put;
    if (auto put = put_figure(out, v->shifts, "Shift, " + v->name, "Pixel by pixel"); !put) return put;
  }
  out += "</div>\n";
  return {};
}

}  // namespace tintree::audit
