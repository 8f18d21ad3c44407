#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/common/whole_file.h"
#include "apps/view/playback.h"
#include "apps/view/still.h"
#include "apps/view/view_options.h"
#include "apps/view/window.h"
#include "cache/tile_store.h"
#include "render/flight.h"
#include "render/gl_context.h"

namespace tintree::view {
namespace {

Expected<void> run(const CommandLine& line) {
  const auto begun = std::chrono::steady_clock::now();
  const auto options = read_options(line);
  if (!options) return tl::unexpected(options.error());
  std::vector<std::string> inputs = options->trees;
  if (!options->flight.empty()) inputs.push_back(options->flight);
  for (const std::string& output : {options->screenshot, options->json}) {
    if (output.empty()) continue;
    if (auto writable = app::check_output_file(output, inputs); !writable) return writable;
  }
  std::optional<render::Flight> flight;
  if (!options->flight.empty()) {
    auto loaded = render::Flight::load(options->flight);
    if (!loaded) return tl::unexpected(loaded.error());
    flight = std::move(*loaded);
  }
  std::vector<cache::TileStore> opened;
  for (const std::string& tree : options->trees) {
    auto store = cache::TileStore::open(tree);
    if (!store) return tl::unexpected(store.error());
    opened.push_back(std::move(*store));
  }
  std::vector<const cache::TileStore*> stores;
  for (const cache::TileStore& store : opened) stores.push_back(&store);
  if (!options->headless) return run_window(stores, *options, std::move(flight), begun);
  const auto context = render::HeadlessContext::create(*options->headless);
  if (!context) return tl::unexpected(context.error());
  const auto gl = render::load_gl((*context)->get_function());
  if (!gl) return tl::unexpected(gl.error());
  if (flight) return play_flight(*gl, stores, *flight, *options);
  return draw_still(*gl, stores, *options, begun);
}

}  // namespace
}  // namespace tintree::view

int main(int argc, char** argv) {
  using namespace tintree;
  view::CommandLine line;
  CLI::App app{"Draws a tile tree: the coarsest tiles whose error stays under a pixel.", "tintree-view"};
  app.add_option("TREE", line.trees, "The .tintree files: one scene, each where its georeference says")->required();
  app.add_option("--pixel-error", line.pixel_error, "Largest error on the screen, pixels")->capture_default_str();
  app.add_flag("--morph", line.morph, "Let levels of detail flow into each other, for --pixel-error above 1");
  app.add_flag("--impostors", line.impostors,
               "Draw far ground once for several frames, on slow flights over large trees");
  app.add_option("--fog", line.fog_m, "Fog: metres at which it hides the ground");
  app.add_option("--gpu-memory", line.gpu_memory_mib, "Graphics memory for tiles, MiB")->capture_default_str();
  app.add_option("--size", line.size, "WIDTHxHEIGHT of the picture or window, pixels (1280x720)");
  app.add_option("--headless", line.headless, "Draw without a window: egl (graphics card) or osmesa (software)");
  app.add_option("--screenshot", line.screenshot, "Write a PNG once all its tiles are there, and end");
  app.add_option("--eye", line.eye, "X,Y,Z of the eye: metres east, north and up of the DEM's upper-left sample");
  app.add_option("--target", line.target, "X,Y,Z of the picture's middle");
  app.add_option("--show", line.show, "levels or error (by colour), triangles, boxes; may be given several times");
  app.add_option("--sun", line.sun, "AZIMUTH,ELEVATION of the sun, degrees (315,34)");
  app.add_option("--flight", line.flight, "Fly through the keyframes of this JSON file");
  app.add_option("--frames", line.frames, "Write every frame of the flight into this folder as frame-NNNNNN.png");
  app.add_option("--fps", line.fps, "Frames a second of the flight")->capture_default_str();
  app.add_flag("--real-time", line.real_time, "Fly by the clock: late frames skip a part of the way");
  app.add_option("--json", line.json, "Write the picture's or the flight's figures as JSON");
  app.add_flag("--quiet", line.quiet, "Print nothing but errors");
  return app::run_program(app, argc, argv, [&] { return view::run(line); });
}
