#include "apps/audit/image_audit.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "apps/audit/drawn_points.h"
#include "apps/audit/view_audit.h"
#include "apps/audit/view_comparison.h"
#include "render/gl_context.h"
#include "render/terrain_scene.h"

namespace tintree::audit {
namespace {

constexpr std::uint64_t kBlockBytes = std::uint64_t{256} << 20;
/// The method whose trees are drawn by nested levels.
constexpr std::string_view kNested = "nested";

/// Draws views of one tree.
class Painter {
 public:
  static Expected<std::unique_ptr<Painter>> create(const cache::TileStore& store, const ImageOptions& options) {
    auto painter = std::unique_ptr<Painter>(new Painter);
    painter->as_stored_ = !options.impostors && store.manifest().method != kNested;
    auto context = render::HeadlessContext::create(render::Headless::kOsMesa);
    if (!context) context = render::HeadlessContext::create(render::Headless::kEgl);
    if (!context) return tl::unexpected(context.error());
    painter->context_ = std::move(*context);
    auto gl = render::load_gl(painter->context_->get_function());
    if (!gl) return tl::unexpected(gl.error());
    painter->gl_ = std::move(*gl);
    // One sample a pixel: what is compared is what is seen at its centre.
    auto target = render::OffscreenTarget::create(painter->gl_, options.width_px, options.height_px, 1);
    if (!target) return tl::unexpected(target.error());
    painter->target_.emplace(std::move(*target));
    render::SceneOptions scene_options;
    scene_options.cut.pixel_error = options.pixel_error;
    scene_options.impostors = options.impostors;
    for (auto* made : {&painter->scene_, &painter->bare_}) {
      auto scene = render::TerrainScene::create(painter->gl_, store, scene_options);
      if (!scene) return tl::unexpected(scene.error());
      *made = std::move(*scene);
      if (!options.impostors) break;
    }
    return painter;
  }

  const std::string& renderer() const { return gl_.renderer; }

  /// Fills `picture` and what was drawn.
  Expected<DrawnView> draw(const render::Camera& camera, app::RgbImage& picture, render::DrawStats& stats) {
    DrawnView view{camera, {}, {}, {}, as_stored_};
    auto cut = draw(bare_ ? *bare_ : *scene_, camera, false, stats);
    if (!cut) return tl::unexpected(cut.error());
    view.bare_depths_m = read_depths(*cut);
    cut = draw(*scene_, camera, true, stats);
    if (!cut) return tl::unexpected(cut.error());
    view.cut = std::move(*cut);
    view.depths_m = read_depths(view.cut);
    picture = app::RgbImage(camera.width_px, camera.height_px);
    picture.rgb = target_->read_picture().rgb;
    return view;
  }

 private:
  Painter() = default;

  Expected<render::LodCut> draw(render::TerrainScene& scene, const render::Camera& camera, bool skirts,
                                render::DrawStats& stats) {
    auto cut = scene.settle(camera);
    if (!cut) return cut;
    if (auto errors = scene.take_errors(); !errors.empty()) return tl::unexpected(std::move(errors.front()));
    render::Style style;
    style.skirts = skirts;
    stats = scene.draw(*target_, camera, *cut, style);
    return cut;
  }

  std::vector<double> read_depths(const render::LodCut& cut) const {
    const double near_m = scene_->renderer().near_m(cut);
    std::vector<double> depths_m;
    for (const float d : target_->read_depths()) {
      depths_m.push_back(d > 0 ? near_m / static_cast<double>(d) : SurfaceRays::kMiss);
    }
    return depths_m;
  }

  bool as_stored_ = false;
  // In the order in which they must die, the last first.
  std::unique_ptr<render::HeadlessContext> context_;
  render::GlFunctions gl_;
  std::optional<render::OffscreenTarget> target_;
  std::unique_ptr<render::TerrainScene> scene_;
  std::unique_ptr<render::TerrainScene> bare_;  ///< For pictures without skirts, whose impostors lack them, too.
};

/// What is wrong with a view, in words; empty when nothing is.
std::string faults_of(const ViewReport& v) {
  if (v.crack_px > 0) return fmt::format("the background is seen through the terrain at {} pixels", v.crack_px);
  if (!(v.shift_max_px <= v.limit_px * (1 + 1e-6))) {
    return fmt::format("the drawn mesh is off by {:.4g} pixels where {:.4g} are allowed", v.shift_max_px, v.limit_px);
  }
  if (!(v.distance_max_px <= v.limit_px * (1 + 1e-6))) {
    return fmt::format("the drawn mesh is {:.4g} pixels' footprints from the surface where {:.4g} are allowed",
                       v.distance_max_px, v.limit_px);
  }
  if (!(v.drawn_max_px <= v.limit_px + kDriverPx)) {
    return fmt::format("a drawn point is off by {:.4g} pixels where {:.4g} are allowed", v.drawn_max_px, v.limit_px);
  }
  if (v.silhouette_px > 0) {
    return fmt::format("{} pixels show terrain farther than a pixel outside its outline", v.silhouette_px);
  }
  return {};
}

void judge(const ViewReport& v, std::vector<Violation>& violations) {
  const std::string fault = faults_of(v);
  if (fault.empty()) return;
  violations.push_back(
      {std::nullopt, ViolationKind::kImage,
       fmt::format("view {} (--eye {:.6f},{:.6f},{:.6f} --target {:.6f},{:.6f},{:.6f}): {}", v.name, v.eye_m[0],
                   v.eye_m[1], v.eye_m[2], v.target_m[0], v.target_m[1], v.target_m[2], fault),
       std::isfinite(v.shift_max_px) ? v.shift_max_px / v.limit_px : kStructural / 2});
}

}  // namespace

Expected<ImageReport> audit_images(const AuditContext& context, const ImageOptions& options,
                                   std::vector<Violation>& violations) {
  const auto choose = [&](double highest_m) {
    return choose_viewpoints(context.store.manifest().layout, highest_m, options);
  };
  return audit_views(context, options, choose, violations);
}

Expected<ImageReport> audit_views(const AuditContext& context, const ImageOptions& options,
                                  const std::function<std::vector<Viewpoint>(double highest_m)>& choose,
                                  std::vector<Violation>& violations) {
  const auto begun = std::chrono::steady_clock::now();
  const std::shared_ptr<const cache::RasterSource> source(std::shared_ptr<void>(), &context.source);
  const auto rays = SurfaceRays::scan(source, kBlockBytes, context.advance);
  if (!rays) return tl::unexpected(rays.error());
  const auto painter = Painter::create(context.store, options);
  if (!painter) return tl::unexpected(painter.error());
  ImageReport report;
  report.renderer = (*painter)->renderer();
  report.width_px = options.width_px;
  report.height_px = options.height_px;
  report.pixel_error = options.pixel_error;
  int to_come = 1;  // Before the next view that is compared.
  for (const Viewpoint& view : choose(rays->highest_m())) {
    app::RgbImage picture;
    render::DrawStats stats;
    const auto drawn = (*painter)->draw(view.camera, picture, stats);
    if (!drawn) return tl::unexpected(drawn.error());
    if (--to_come > 0) continue;
    to_come = options.compared_every;
    auto compared = compare_view(context, *rays, *drawn, options.pixel_error);
    if (!compared) return tl::unexpected(compared.error());
    compared->name = view.name;
    compared->eye_m = {view.camera.eye.x, view.camera.eye.y, view.camera.eye.z};
    compared->target_m = {view.camera.target.x, view.camera.target.y, view.camera.target.z};
    compared->tiles = stats.tiles;
    compared->triangles = stats.triangles;
    compared->impostor_tiles = stats.impostor_tiles;
    compared->picture = std::move(picture);
    judge(*compared, violations);
    report.views.push_back(std::move(*compared));
    if (!context.advance(0)) return tl::unexpected(stopped_error());
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return report;
}

}  // namespace tintree::audit
