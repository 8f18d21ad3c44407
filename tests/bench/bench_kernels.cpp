#include <cmath>
#include <cstdint>
#include <memory>

#include <benchmark/benchmark.h>

#include "cache/height_blocks.h"
#include "cache/raster_source.h"
#include "codec/mesh_codec.h"
#include "simplify/reference_surface.h"
#include "simplify/tile_maker.h"
#include "simplify/tree_builder.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace {

using namespace tintree;

/// A made terrain of 513 x 513 samples in one tile or four, whose error bound is half the spacing.
struct Scene {
  std::unique_ptr<simplify::ReferenceSurface> surface;
  codec::TreeLayout layout;

  Scene() {
    const test::TempDir folder;
    const std::string path = folder.file("dem.tif");
    test::RasterSpec spec;
    spec.columns = spec.rows = 513;
    test::write_raster(path, spec, [](int c, int r) {
      return 30 * std::sin(c / 40.0) * std::cos(r / 55.0) + 6 * std::sin(c / 7.0 + r / 9.0) +
             0.3 * std::sin(c * 12.9 + r * 78.2);
    });
    auto source = std::make_shared<cache::RasterSource>(std::move(*cache::RasterSource::open(path)));
    auto blocks = std::make_shared<cache::HeightBlocks>(source, std::uint64_t{64} << 20);
    surface = std::move(*simplify::ReferenceSurface::scan(blocks, [](std::uint64_t, std::uint64_t) { return true; }));
    layout.columns = layout.rows = 513;
    layout.leaf_level = 1;
    layout.leaf_error_m = 0.5;
    layout.z_step_m = *simplify::choose_height_steps(*surface, layout);
  }
};

const Scene& scene() {
  static const Scene s;
  return s;
}

std::unique_ptr<simplify::TileMaker> make_maker() {
  cache::Manifest manifest;
  manifest.layout = scene().layout;
  return simplify::make_tile_maker(manifest, *scene().surface);
}

/// Samples a second of making one tile; argument: its level (1 a leaf, 0 its parent).
void make_tile(benchmark::State& state) {
  const auto maker = make_maker();
  const codec::TileId id{static_cast<int>(state.range(0)), 0, 0};
  const std::int64_t cells = scene().layout.cells_across(id.level);
  for (auto _ : state) benchmark::DoNotOptimize(maker->make(id));
  state.SetItemsProcessed(state.iterations() * cells * cells);
}
BENCHMARK(make_tile)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

/// Vertices a second through the codec.
void encode(benchmark::State& state) {
  const auto mesh = *make_maker()->make({1, 0, 0});
  const codec::MeshCodec& codec = *codec::find_codec("tin");
  for (auto _ : state) benchmark::DoNotOptimize(codec.encode(mesh));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.vertices.size()));
}
BENCHMARK(encode)->Unit(benchmark::kMicrosecond);

void decode(benchmark::State& state) {
  const auto mesh = *make_maker()->make({1, 0, 0});
  const codec::MeshCodec& codec = *codec::find_codec("tin");
  const auto bytes = *codec.encode(mesh);
  for (auto _ : state) benchmark::DoNotOptimize(codec.decode(bytes));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.vertices.size()));
}
BENCHMARK(decode)->Unit(benchmark::kMicrosecond);

}  // namespace
