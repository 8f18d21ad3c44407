/// bench_decode: what it costs to read a level of a tree, in processor time; one line of JSON.

#include <cstdint>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/program.h"
#include "cache/tile_store.h"
#include "tests/bench/rivals/cpu_clock.h"

namespace {

using namespace tintree;

/// Reads, verifies, decodes and validates every tile as tintree-view's cache does.
Expected<void> decode(const cache::TileStore& store, const std::vector<codec::TileId>& tiles) {
  for (const codec::TileId& id : tiles) {
    if (const auto mesh = store.read_mesh(id); !mesh) return tl::unexpected(mesh.error());
  }
  return {};
}

Expected<void> run(const std::string& tree, int level) {
  const auto store = cache::TileStore::open(tree);
  if (!store) return tl::unexpected(store.error());
  std::vector<codec::TileId> tiles;
  for (const cache::TileNode& node : store->bounds().nodes()) {
    if (node.id.level == level) tiles.push_back(node.id);
  }
  if (tiles.empty()) return fail(ErrorCode::kUsage, "the tree has no tiles of that level", "LEVEL");
  if (auto sound = decode(*store, tiles); !sound) return sound;
  const double seconds = bench::least_seconds([&] { (void)decode(*store, tiles); });
  fmt::print("{}\n", nlohmann::json{{"tiles", tiles.size()}, {"decode_seconds", seconds}}.dump());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Reads and decodes every tile of a tree's level, and says how long that takes", "bench_decode"};
  std::string tree;
  int level = 0;
  app.add_option("TREE", tree, "The .tintree file")->required();
  app.add_option("LEVEL", level, "0 is the root")->required();
  return app::run_program(app, argc, argv, [&] { return run(tree, level); });
}
