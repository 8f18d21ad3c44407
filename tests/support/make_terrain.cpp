/// Writes an adversarial terrain as a GeoTIFF, for programs: make_terrain NAME OUT.tif. Without arguments it
/// lists the names; random_SEED names any number more.

#include <cstdio>
#include <exception>

#include <fmt/core.h>

#include "tests/support/adversarial_terrain.h"

int main(int argc, char** argv) {
  using namespace tintree::test;
  constexpr int kUsage = 2;
  constexpr int kIo = 4;
  if (argc == 1) {
    for (const AdversarialTerrain& t : adversarial_terrains()) {
      fmt::print("{:<22} {:<8} {:>4} x {:<4} {}\n", t.name, t.family, t.columns, t.rows, t.about);
    }
    return 0;
  }
  if (argc != 3) {
    fmt::print(stderr, "make_terrain: give a name and a file to write: make_terrain NAME OUT.tif\n");
    return kUsage;
  }
  const auto terrain = find_terrain(argv[1]);
  if (!terrain) {
    fmt::print(stderr, "make_terrain: {}: no such terrain; make_terrain lists them\n", argv[1]);
    return kUsage;
  }
  try {
    write_terrain(argv[2], *terrain);
  } catch (const std::exception& e) {
    fmt::print(stderr, "make_terrain: {}\n", e.what());
    return kIo;
  }
}
