/// bench_view: every Nth view of a flight, against the full-resolution surface (the audit's measure), against drawing
/// the same triangles and textures from one static buffer, and with and without looking for what nearer ground hides;
/// or, with
/// --impostors, against the surface alone. Prints one line of JSON; scripts/bench view reads it.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/audit/view_audit.h"
#include "apps/common/program.h"
#include "render/flight.h"
#include "render/gl_context.h"
#include "tests/bench/view/static_scene.h"

namespace tintree::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string tree;
  std::string dem;
  std::string flight;
  std::string headless = "osmesa";
  double fps = 30;
  int every = 20;
  int width_px = 1280;
  int height_px = 720;
  int repeats = 7;
  bool impostors = false;
};

std::vector<render::Camera> cameras(const render::Flight& flight, const Options& o, int every) {
  std::vector<render::Camera> out;
  const auto frames = static_cast<int>(std::floor((flight.end_s() - flight.begin_s()) * o.fps + 1e-9));
  for (int i = 0; i <= frames; i += every)
    out.push_back(flight.at(flight.begin_s() + i / o.fps, o.width_px, o.height_px));
  return out;
}

/// Steps of 255: one lattice for the whole view moves vertices by less than a pixel.
constexpr double kMostDifference = 1;

template <typename Draw>
double seconds_of(const render::GlFunctions& gl, const Draw& draw) {
  gl.Finish();
  const Clock::time_point begun = Clock::now();
  draw();
  gl.Finish();
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

/// How far two pictures of a size are apart, in steps of 255: the mean of their pixels.
double mean_difference(const render::Picture& a, const render::Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::abs(int{a.rgb[i]} - int{b.rgb[i]});
  return sum / static_cast<double>(a.rgb.size());
}

/// Frame by frame the whole of a frame, cut and all, and the static buffer's, in turn; the least of the repeats.
/// Fails with kCheckFailed where the two show different things.
Expected<nlohmann::json> against_static(const cache::TileStore& store, const std::vector<render::Camera>& views,
                                        const Options& o) {
  const auto kind = o.headless == "egl" ? render::Headless::kEgl : render::Headless::kOsMesa;
  const auto context = render::HeadlessContext::create(kind);
  if (!context) return tl::unexpected(context.error());
  const auto gl = render::load_gl((*context)->get_function());
  if (!gl) return tl::unexpected(gl.error());
  const auto target = render::OffscreenTarget::create(*gl, o.width_px, o.height_px, 4);
  if (!target) return tl::unexpected(target.error());
  render::SceneOptions options;
  options.cache_bytes = std::size_t{2} << 30;
  const auto made = render::TerrainScene::create(*gl, store, options);
  if (!made) return tl::unexpected(made.error());
  render::TerrainScene& scene = **made;
  double scene_seconds = 0, static_seconds = 0;
  std::uint64_t triangles = 0;
  double difference = 0;
  for (const render::Camera& camera : views) {
    const auto cut = scene.settle(camera);
    if (!cut) return tl::unexpected(cut.error());
    const auto baked = StaticScene::bake(*gl, scene, *cut);
    if (!baked) return tl::unexpected(baked.error());
    double best_scene = std::numeric_limits<double>::infinity();
    double best_static = best_scene;
    for (int i = 0; i < o.repeats; ++i) {
      best_scene = std::min(best_scene, seconds_of(*gl, [&] {
                              const render::LodCut again = scene.update(camera);
                              scene.draw(*target, camera, again, {});
                            }));
      best_static = std::min(best_static, seconds_of(*gl, [&] { (*baked)->draw(scene.renderer(), *target, camera); }));
    }
    (*baked)->draw(scene.renderer(), *target, camera);
    const render::Picture still = target->read_picture();
    triangles += scene.draw(*target, camera, *cut, {}).triangles;
    difference = std::max(difference, mean_difference(still, target->read_picture()));
    if (difference > kMostDifference) {
      return fail(ErrorCode::kCheckFailed, fmt::format("the static buffer shows something else than the frame: pixels "
                                                       "are {:.2f} steps of 255 apart",
                                                       difference));
    }
    scene_seconds += best_scene;
    static_seconds += best_static;
  }
  const auto count = static_cast<double>(views.size());
  return nlohmann::json{{"renderer", gl->renderer},
                        {"triangles_per_frame", static_cast<double>(triangles) / count},
                        {"scene_seconds", scene_seconds / count},
                        {"static_seconds", static_seconds / count},
                        {"static_difference", difference},
                        {"ratio", scene_seconds / static_seconds}};
}

/// Three ways of each view, loading included, are slow: fewer views, less often.
constexpr int kWayEvery = 6;
constexpr int kWayRepeats = 3;

/// A flight over these views once for each way to look for what nearer ground hides, in turn; the least processor time
/// of all threads that a frame took.
Expected<nlohmann::json> of_occlusion(const cache::TileStore& store, const std::vector<render::Camera>& views,
                                      const Options& o) {
  const auto kind = o.headless == "egl" ? render::Headless::kEgl : render::Headless::kOsMesa;
  const auto context = render::HeadlessContext::create(kind);
  if (!context) return tl::unexpected(context.error());
  const auto gl = render::load_gl((*context)->get_function());
  if (!gl) return tl::unexpected(gl.error());
  const auto target = render::OffscreenTarget::create(*gl, o.width_px, o.height_px, 4);
  if (!target) return tl::unexpected(target.error());
  const auto made = render::TerrainScene::create(*gl, store, {});
  if (!made) return tl::unexpected(made.error());
  render::TerrainScene& scene = **made;
  struct Way {
    const char* name;
    render::Occlusion wish;
    std::clock_t least = std::numeric_limits<std::clock_t>::max();
    std::clock_t least_choosing = std::numeric_limits<std::clock_t>::max();
    std::uint64_t hidden = 0;
    std::uint64_t triangles = 0;
  };
  std::array<Way, 3> ways{{{"off", render::Occlusion::kOff},
                           {"where_it_pays", render::Occlusion::kWhereItPays},
                           {"always", render::Occlusion::kAlways}}};
  for (int repeat = 0; repeat < kWayRepeats; ++repeat) {
    for (Way& way : ways) {
      scene.occlusion() = way.wish;
      way.hidden = way.triangles = 0;
      std::clock_t spent = 0, choosing = 0;
      for (const render::Camera& camera : views) {
        if (auto ready = scene.settle(camera); !ready) return tl::unexpected(ready.error());
        gl->Finish();
        const std::clock_t before = std::clock();
        const render::LodCut cut = scene.update(camera);
        choosing += std::clock() - before;
        way.triangles += scene.draw(*target, camera, cut, {}).triangles;
        gl->Finish();
        spent += std::clock() - before;
        way.hidden += cut.occluded;
      }
      way.least = std::min(way.least, spent);
      way.least_choosing = std::min(way.least_choosing, choosing);
    }
  }
  nlohmann::json out;
  const auto count = static_cast<double>(views.size());
  for (const Way& way : ways) {
    out[way.name] = {{"cpu_seconds", static_cast<double>(way.least) / CLOCKS_PER_SEC / count},
                     {"choosing_cpu_seconds", static_cast<double>(way.least_choosing) / CLOCKS_PER_SEC / count},
                     {"hidden", static_cast<double>(way.hidden) / count},
                     {"triangles", static_cast<double>(way.triangles) / count}};
  }
  return out;
}

Expected<nlohmann::json> against_surface(const cache::TileStore& store, const std::vector<render::Camera>& views,
                                         const Options& o) {
  auto source = cache::RasterSource::open(o.dem);
  if (!source) return tl::unexpected(source.error());
  cache::StageOptions stage;
  stage.nodata = store.manifest().nodata;
  stage.folder = std::filesystem::temp_directory_path();
  if (auto staged = source->stage(stage); !staged) return tl::unexpected(staged.error());
  const audit::AuditContext context{store, *source, [](std::int64_t) { return true; }};
  audit::ImageOptions options;
  options.width_px = o.width_px;
  options.height_px = o.height_px;
  options.impostors = o.impostors;
  options.compared_every = o.impostors ? o.every : 1;
  std::vector<audit::Violation> violations;
  const auto choose = [&](double) {
    std::vector<audit::Viewpoint> out;
    for (const render::Camera& c : views) out.push_back({fmt::format("frame {}", out.size()), c});
    return out;
  };
  const auto report = audit::audit_views(context, options, choose, violations);
  if (!report) return tl::unexpected(report.error());
  std::uint64_t cracks = 0, silhouette = 0, with_impostor = 0;
  double shift = 0, share = 0, drawn = 0, limit = 0;
  for (const audit::ViewReport& v : report->views) {
    cracks += v.crack_px;
    silhouette += v.silhouette_px;
    with_impostor += v.impostor_tiles > 0 ? 1 : 0;
    shift = std::max(shift, v.shift_max_px);
    share = std::max(share, v.shift_max_px / v.limit_px);
    drawn = std::max(drawn, v.drawn_max_px);
    limit = std::max(limit, v.limit_px);
  }
  const auto worst = std::ranges::max_element(violations, {}, &audit::Violation::severity);
  return nlohmann::json{{"views", report->views.size()},
                        {"crack_px", cracks},
                        {"silhouette_px", silhouette},
                        {"shift_max_px", shift},
                        {"limit_px", limit},
                        {"shift_of_limit", share},
                        {"drawn_max_px", drawn},
                        {"with_impostor", with_impostor},
                        {"violations", violations.size()},
                        {"worst_violation", worst == violations.end() ? "" : worst->text()}};
}

Expected<void> run(const Options& o) {
  const auto store = cache::TileStore::open(o.tree);
  if (!store) return tl::unexpected(store.error());
  const auto flight = render::Flight::load(o.flight);
  if (!flight) return tl::unexpected(flight.error());
  // An impostor lives by the frames before.
  const auto views = cameras(*flight, o, o.impostors ? 1 : o.every);
  if (o.impostors) {
    const auto image = against_surface(*store, views, o);
    if (!image) return tl::unexpected(image.error());
    fmt::print("{}\n", image->dump());
    return {};
  }
  const auto cost = against_static(*store, views, o);
  if (!cost) return tl::unexpected(cost.error());
  const auto occlusion = of_occlusion(*store, cameras(*flight, o, kWayEvery * o.every), o);
  if (!occlusion) return tl::unexpected(occlusion.error());
  nlohmann::json out{{"cost", *cost}, {"occlusion", *occlusion}};
  if (!o.dem.empty()) {
    const auto image = against_surface(*store, views, o);
    if (!image) return tl::unexpected(image.error());
    out["image"] = *image;
  }
  fmt::print("{}\n", out.dump());
  return {};
}

}  // namespace
}  // namespace tintree::bench

int main(int argc, char** argv) {
  using namespace tintree;
  bench::Options o;
  CLI::App app{"Every Nth view of a flight against the surface and against a static buffer.", "bench_view"};
  app.add_option("TREE", o.tree)->required();
  app.add_option("--flight", o.flight)->required();
  app.add_option("--dem", o.dem, "Compare pictures with this DEM too");
  app.add_option("--headless", o.headless)->check(CLI::IsMember({"osmesa", "egl"}));
  app.add_option("--fps", o.fps);
  app.add_option("--every", o.every)->check(CLI::PositiveNumber);
  app.add_flag("--impostors", o.impostors, "Fly with them and compare pictures alone")->needs("--dem");
  app.add_option("--width", o.width_px);
  app.add_option("--height", o.height_px);
  return app::run_program(app, argc, argv, [&] { return bench::run(o); });
}
