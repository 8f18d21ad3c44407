// What a program that uses the installed libraries looks like.

#include <cstdio>

#include "cache/tile_store.h"
#include "codec/mesh_codec.h"

int main(int argc, char** argv) {
  const auto tree = tintree::cache::TileStore::open(argc > 1 ? argv[1] : "no_such.tintree");
  if (!tree) {
    std::printf("%s\n", tree.error().text().c_str());
    return argc > 1 || tintree::codec::find_codec("tin") == nullptr ? 1 : 0;
  }
  for (const auto& node : tree->bounds().nodes()) {
    std::printf("%s: within %g m\n", node.id.text().c_str(), static_cast<double>(node.lod_error_m));
  }
}
