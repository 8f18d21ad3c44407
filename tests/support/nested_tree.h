#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "cache/tile_store.h"
#include "codec/nested_mesh.h"
#include "codec/nested_points.h"

namespace tintree::test {

/// A small tree of method `nested` over an analytic height function, written without the builder: 257 x 257 samples,
/// tiles of 64 cells on three levels. The leaves' own meshes lack points that their parents' have.
struct NestedTree {
  static constexpr double kSpacing_m = 5;
  static constexpr double kStep_m = 1.0 / 64;

  static double ground_m(double x, double y) {
    return 50 * std::sin(x / 90) * std::cos(y / 70) + 14 * std::sin(x / 19 + y / 23);
  }

  static codec::TreeLayout layout() {
    codec::TreeLayout out;
    out.columns = out.rows = 257;
    out.tile_cells = 64;
    out.leaf_level = 2;
    out.dx_m = out.dy_m = kSpacing_m;
    out.leaf_error_m = 9;
    out.z_step_m.assign(3, kStep_m);
    return out;
  }

  /// Every 4th sample of a leaf, every 2nd below the root, every 4th of the root, coming level by level as triangles
  /// are halved.
  /// `hole`: places of the tile, 0 to 64, that are left out.
  static codec::TileMesh mesh(const codec::TileId& id,
                              const std::function<bool(std::int32_t, std::int32_t)>& hole = nullptr) {
    const codec::TreeLayout l = layout();
    const std::int64_t step = l.cells_across(id.level) / 64;
    const std::int32_t apart = id.level == 2 ? 4 : 1;
    codec::NestedPoints points(6);
    const auto add = [&](std::int32_t x, std::int32_t y, int level) {
      const double east = static_cast<double>((id.x * 64 + x) * step) * kSpacing_m;
      const double south = static_cast<double>((id.y * 64 + y) * step) * kSpacing_m;
      points.add({x, y, static_cast<std::int32_t>(std::lround((ground_m(east, -south) + 100) / kStep_m)),
                  static_cast<std::uint8_t>(level), hole && hole(x, y)});
    };
    for (std::int32_t i = 0; i < codec::NestedPoints::kBasePoints; ++i) {
      const auto [x, y] = points.base_place(i);
      add(x, y, 0);
    }
    for (std::int32_t y = 0; y <= 64; y += apart) {
      for (std::int32_t x = 0; x <= 64; x += apart) {
        if (points.find(x, y) >= 0) continue;
        const int unit = (x | y) & -(x | y);
        int depth = (x & y & unit) != 0 ? 0 : 1;
        for (int u = unit; u < 32; u *= 2) depth += 2;
        add(x, y, std::min(8, depth * 3 / 4));
      }
    }
    codec::TileMesh out = codec::finest_mesh(points);
    out.z_offset = -6400;
    out.xy_shift = l.leaf_level - id.level;
    return out;
  }

  /// That is stored of every tile. Regular triangles with legs h over this ground are off by h²/4 times its sharpest
  /// bend at most, which is 8.4 m in the leaves and the root.
  static double error_m(int level) { return 0.95 * layout().bound_m(level); }

  static cache::TileInfo info(const codec::TileId& id, const codec::TileMesh& mesh) {
    cache::TileInfo out;
    out.id = id;
    out.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
    out.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
    const auto [low, high] = std::ranges::minmax(mesh.vertices, {}, &codec::GridVertex::z);
    out.z_min_m = static_cast<double>(low.z + mesh.z_offset) * kStep_m;
    out.z_max_m = static_cast<double>(high.z + mesh.z_offset) * kStep_m;
    out.error_m = out.rms_m = error_m(id.level);
    out.border_error_m = out.error_m / 2;
    return out;
  }

  static std::vector<codec::TileId> tiles() {
    std::vector<codec::TileId> out;
    for (int level = 0; level <= 2; ++level) {
      for (std::uint32_t y = 0; y < 1U << level; ++y) {
        for (std::uint32_t x = 0; x < 1U << level; ++x) out.push_back({level, x, y});
      }
    }
    return out;
  }
};

}  // namespace tintree::test
