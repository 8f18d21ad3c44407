/// Method `nested`: making and encoding the leaves, and decoding them to vertices, fans and morphs of all levels.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include "codec/mesh_codec.h"
#include "codec/nested_tile.h"
#include "tests/bench/leaf_scene.h"

namespace {

using namespace tintree;

/// Samples a second of making and encoding all leaves.
void make_leaves(benchmark::State& state) {
  const bench::LeafScene& s = bench::leaf_scene();
  for (auto _ : state) benchmark::DoNotOptimize(s.leaves("nested"));
  state.SetItemsProcessed(state.iterations() * s.layout.columns * s.layout.rows);
}
BENCHMARK(make_leaves)->Unit(benchmark::kMillisecond);

/// Vertices a second, of the leaves' own meshes.
template <typename Decode>
void decode_leaves(benchmark::State& state, const Decode& decode) {
  const std::vector<std::vector<std::byte>> leaves = bench::leaf_scene().leaves("nested");
  std::int64_t vertices = 0;
  for (const auto& leaf : leaves)
    vertices += static_cast<std::int64_t>(codec::find_codec("nested")->decode(leaf)->vertices.size());
  for (auto _ : state) {
    for (const auto& leaf : leaves) benchmark::DoNotOptimize(decode(leaf));
  }
  state.SetItemsProcessed(state.iterations() * vertices);
}

/// With the fans and morphs of all levels.
void decode_levels(benchmark::State& state) {
  decode_leaves(state, [](const std::vector<std::byte>& leaf) { return codec::decode_nested(leaf); });
}
BENCHMARK(decode_levels)->Unit(benchmark::kMicrosecond);

/// To the finest level's mesh alone.
void decode_meshes(benchmark::State& state) {
  decode_leaves(state, [](const std::vector<std::byte>& leaf) { return codec::find_codec("nested")->decode(leaf); });
}
BENCHMARK(decode_meshes)->Unit(benchmark::kMicrosecond);

}  // namespace
