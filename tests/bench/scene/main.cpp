/// bench_scene: how many triangles the views of a flight draw, how many there are at full resolution, and how few
/// would do; one line of JSON a view. Without OpenGL.

#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/program.h"
#include "tests/bench/scene/scene_counts.h"

namespace {

using namespace tintree;

Expected<bench::ErrorLadder> read_ladder(const std::vector<std::string>& trees) {
  bench::ErrorLadder ladder;
  for (const std::string& path : trees) {
    const auto store = cache::TileStore::open(path);
    if (!store) return tl::unexpected(store.error());
    const codec::TreeLayout& layout = store->bounds().layout();
    for (int level = 0; level <= layout.leaf_level; ++level) {
      auto blocks = bench::ground_blocks(*store, level);
      if (!blocks) return tl::unexpected(blocks.error());
      ladder.add(layout.bound_m(level), std::move(*blocks));
    }
  }
  return ladder;
}

nlohmann::json to_json(const render::Camera& camera, const bench::SceneCounts& c) {
  return {{"eye_m", {camera.eye.x, camera.eye.y, camera.eye.z}},
          {"target_m", {camera.target.x, camera.target.y, camera.target.z}},
          {"tiles", c.tiles},
          {"max_error_px", c.max_error_px},
          {"full", c.full},
          {"drawn", c.drawn},
          {"in_picture", c.in_picture},
          {"one_tile", c.one_tile},
          {"any_error", c.any_error},
          {"fewest", c.fewest},
          {"fewest_level", c.fewest_level},
          {"beyond_ladder", c.beyond_ladder}};
}

Expected<void> run(const std::string& tree, const std::vector<std::string>& ladder_trees, int views) {
  const auto store = cache::TileStore::open(tree);
  if (!store) return tl::unexpected(store.error());
  const auto ladder = read_ladder(ladder_trees);
  if (!ladder) return tl::unexpected(ladder.error());
  const auto counter = bench::SceneCounter::open(*store, *ladder);
  if (!counter) return tl::unexpected(counter.error());
  for (const render::Camera& camera : bench::flight(store->bounds(), views)) {
    const auto counts = counter->count(camera);
    if (!counts) return tl::unexpected(counts.error());
    fmt::print("{}\n", to_json(camera, *counts).dump());
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Triangles drawn on a flight, beside the most and the fewest that would do", "bench_scene"};
  std::string tree;
  std::vector<std::string> ladder;
  int views = 24;
  app.add_option("TREE", tree, "The tree that is drawn")->required();
  app.add_option("--ladder", ladder, "Trees of the same DEM with large tiles, all of whose levels are rungs")
      ->required();
  app.add_option("--views", views, "Along the flight")->check(CLI::PositiveNumber);
  return app::run_program(app, argc, argv, [&] { return run(tree, ladder, views); });
}
