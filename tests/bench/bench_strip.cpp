/// Method `strip`: making, encoding and decoding a leaf. Bytes are those of the unpacked list, 12 a triangle.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "codec/mesh_codec.h"
#include "codec/strip_list.h"
#include "tests/bench/leaf_scene.h"

namespace {

using namespace tintree;

/// Samples a second of making and encoding all leaves.
void make_leaves(benchmark::State& state) {
  const bench::LeafScene& s = bench::leaf_scene();
  for (auto _ : state) benchmark::DoNotOptimize(s.leaves("strip"));
  state.SetItemsProcessed(state.iterations() * s.layout.columns * s.layout.rows);
}
BENCHMARK(make_leaves)->Unit(benchmark::kMillisecond);

template <typename Decode>
void decode_leaves(benchmark::State& state, const std::string& effort, const Decode& decode) {
  const std::vector<std::vector<std::byte>> leaves = bench::leaf_scene().leaves("strip", effort);
  std::int64_t triangles = 0;
  std::int64_t bytes = 0;
  for (const auto& leaf : leaves) {
    triangles += static_cast<std::int64_t>(codec::find_codec("strip")->decode(leaf)->triangles.size());
    bytes += static_cast<std::int64_t>(leaf.size());
  }
  for (auto _ : state) {
    for (const auto& leaf : leaves) decode(leaf);
  }
  state.SetBytesProcessed(state.iterations() * 12 * triangles);
  state.counters["bits/triangle"] = static_cast<double>(8 * bytes) / static_cast<double>(triangles);
}

/// Into lists of words, memory reused.
template <void (*Decoder)(const codec::StripPayload&, std::span<std::uint32_t>)>
void decode_words(benchmark::State& state) {
  std::vector<std::uint32_t> words;
  decode_leaves(state, "fast", [&](const std::vector<std::byte>& leaf) {
    const codec::StripPayload payload = *codec::open_strip(leaf);
    if (!codec::StripWords(payload).fit()) return state.SkipWithError("a tile is too tall for words");
    if (words.size() < 3 * payload.triangles) words.resize(3 * payload.triangles);
    Decoder(payload, std::span(words).first(3 * payload.triangles));
    benchmark::DoNotOptimize(words.data());
    benchmark::ClobberMemory();
  });
}
BENCHMARK(decode_words<codec::follow_strip>)->Unit(benchmark::kMicrosecond);
BENCHMARK(decode_words<codec::expand_sub_strips>)->Unit(benchmark::kMicrosecond);

/// Into meshes, checked.
void decode_meshes(benchmark::State& state, const std::string& effort) {
  decode_leaves(state, effort, [&](const std::vector<std::byte>& leaf) {
    benchmark::DoNotOptimize(codec::find_codec("strip")->decode(leaf));
  });
}
BENCHMARK_CAPTURE(decode_meshes, fast, std::string("fast"))->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(decode_meshes, best, std::string("best"))->Unit(benchmark::kMicrosecond);

}  // namespace
