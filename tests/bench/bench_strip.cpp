/// Method `strip`: making, encoding and decoding a leaf. Bytes are those of the unpacked list, 12 a triangle.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "cache/height_blocks.h"
#include "cache/raster_source.h"
#include "codec/mesh_codec.h"
#include "codec/strip_list.h"
#include "simplify/reference_surface.h"
#include "simplify/tile_maker.h"
#include "simplify/tree_builder.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace {

using namespace tintree;

/// TINTREE_BENCH_DEM, or a made terrain of 513 x 513 samples; leaves of 256 cells, the bound half the spacing.
struct Scene {
  std::unique_ptr<simplify::ReferenceSurface> surface;
  codec::TreeLayout layout;

  Scene() {
    const test::TempDir folder;
    std::string path = folder.file("dem.tif");
    if (const char* given = std::getenv("TINTREE_BENCH_DEM")) {
      path = given;
    } else {
      test::write_raster(path, {.columns = 513, .rows = 513}, [](int c, int r) {
        return 30 * std::sin(c / 40.0) * std::cos(r / 55.0) + 6 * std::sin(c / 7.0 + r / 9.0) +
               0.3 * std::sin(c * 12.9 + r * 78.2);
      });
    }
    auto source = std::make_shared<cache::RasterSource>(std::move(*cache::RasterSource::open(path)));
    layout.columns = source->info().columns;
    layout.rows = source->info().rows;
    layout.dx_m = source->info().dx_m;
    layout.dy_m = source->info().dy_m;
    auto blocks = std::make_shared<cache::HeightBlocks>(source, std::uint64_t{512} << 20);
    surface = std::move(*simplify::ReferenceSurface::scan(blocks, [](std::uint64_t, std::uint64_t) { return true; }));
    layout.leaf_level = codec::TreeLayout::leaf_level_for(layout.columns, layout.rows, layout.tile_cells);
    layout.leaf_error_m = std::sqrt(layout.dx_m * layout.dy_m) / 2;
    layout.z_step_m = *simplify::choose_height_steps(*surface, layout);
  }

  /// The payloads of the leaves.
  std::vector<std::vector<std::byte>> leaves(const std::string& effort = "fast") const {
    cache::Manifest manifest;
    manifest.method = "strip";
    manifest.effort = effort;
    manifest.layout = layout;
    const auto maker = simplify::make_tile_maker(manifest, *surface);
    const codec::MeshCodec& codec = *codec::find_codec("strip");
    std::vector<std::vector<std::byte>> out;
    const int level = layout.leaf_level;
    for (std::uint32_t y = 0; y < layout.tiles_y(level); ++y) {
      for (std::uint32_t x = 0; x < layout.tiles_x(level); ++x) {
        const auto mesh = maker->make({level, x, y});
        if (!mesh->triangles.empty()) out.push_back(*maker->encode(codec, {level, x, y}, *mesh));
      }
    }
    return out;
  }
};

const Scene& scene() {
  static const Scene s;
  return s;
}

/// Samples a second of making and encoding all leaves.
void make_leaves(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) benchmark::DoNotOptimize(s.leaves());
  state.SetItemsProcessed(state.iterations() * s.layout.columns * s.layout.rows);
}
BENCHMARK(make_leaves)->Unit(benchmark::kMillisecond);

template <typename Decode>
void decode_leaves(benchmark::State& state, const std::string& effort, const Decode& decode) {
  const std::vector<std::vector<std::byte>> leaves = scene().leaves(effort);
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
