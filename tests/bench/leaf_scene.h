#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "cache/height_blocks.h"
#include "cache/raster_source.h"
#include "codec/mesh_codec.h"
#include "simplify/reference_surface.h"
#include "simplify/tile_maker.h"
#include "simplify/tree_builder.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::bench {

/// TINTREE_BENCH_DEM, or a made terrain of 513 x 513 samples; leaves of 256 cells, the bound half the spacing.
struct LeafScene {
  std::unique_ptr<simplify::ReferenceSurface> surface;
  codec::TreeLayout layout;

  LeafScene() {
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
  std::vector<std::vector<std::byte>> leaves(const std::string& method, const std::string& effort = "fast") const {
    cache::Manifest manifest;
    manifest.method = method;
    manifest.effort = effort;
    manifest.layout = layout;
    const auto maker = simplify::make_tile_maker(manifest, *surface);
    const codec::MeshCodec& codec = *codec::find_codec(method);
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

inline const LeafScene& leaf_scene() {
  static const LeafScene s;
  return s;
}

}  // namespace tintree::bench
