#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cache/tile_store.h"
#include "codec/mesh_codec.h"
#include "codec/texture_codec.h"

namespace tintree::test {

/// A small tree of regular meshes over an analytic height function, written without the builder: each level up takes
/// every second sample, so that with one level a doubling every level's tile has the same number of cells.
struct AnalyticTree {
  std::int64_t columns = 129;
  std::int64_t rows = 129;
  int tile_cells = 32;
  int levels_per_doubling = 1;
  double spacing_m = 10;
  codec::GridAxes axes = {};
  std::array<double, 6> geotransform = {};
  std::function<double(double x_m, double y_m)> height_m = [](double x, double y) {
    return 60 * std::sin(x / 170) * std::cos(y / 130) + 25 * std::sin(x / 41 + y / 57);
  };

  /// The sRGB colour of all texels of a tile's texture; without it there are no textures.
  std::function<std::array<std::uint8_t, 3>(const codec::TileId&)> color;
  /// The same of the texel at a place on the grid, in place of `color`.
  std::function<std::array<std::uint8_t, 3>(const codec::TileId&, double column, double row)> photo;
  int texture_size = 16;
  int texture_depth = 0;  ///< How often leaves are halved for finer textures,
  /// and whether a square that they are halved to has one; without it all have.
  std::function<bool(const codec::TileId&)> has_texture;

  /// Where there is no ground: a cell of a mesh is left out when its middle lies there.
  std::function<bool(double x_m, double y_m)> hole;

  codec::TreeLayout layout() const {
    codec::TreeLayout out;
    out.columns = columns;
    out.rows = rows;
    out.tile_cells = tile_cells;
    out.levels_per_doubling = levels_per_doubling;
    out.leaf_level = codec::TreeLayout::leaf_level_for(columns, rows, tile_cells, levels_per_doubling);
    out.dx_m = out.dy_m = spacing_m;
    out.axes = axes;
    out.leaf_error_m = 0.05;
    out.z_step_m.assign(static_cast<std::size_t>(out.leaf_level) + 1, 0.0625);
    return out;
  }

  /// Samples from one of the level's meshes' to the next.
  static std::int64_t stride(const codec::TreeLayout& l, int level) {
    return std::min(std::int64_t{1} << (l.leaf_level - level), l.cells_across(level));
  }

  /// Height of a sample in steps.
  std::int64_t steps(std::int64_t column, std::int64_t row) const {
    const double z = height_m(static_cast<double>(column) * spacing_m, -static_cast<double>(row) * spacing_m);
    return std::llround(z / 0.0625);
  }

  /// Positions along one axis: every `step`th sample, and the raster's last one.
  static std::vector<std::int64_t> positions(std::int64_t first, std::int64_t last, std::int64_t step) {
    std::vector<std::int64_t> out;
    for (std::int64_t p = first; p < last; p += step) out.push_back(p);
    out.push_back(last);
    return out;
  }

  codec::TileMesh mesh(const codec::TileId& id) const {
    const codec::TreeLayout l = layout();
    const codec::CellRect c = l.cells(id);
    const std::int64_t step = stride(l, id.level);
    const auto xs = positions(c.column0, c.column1, step);
    const auto ys = positions(c.row0, c.row1, step);
    codec::TileMesh out;
    out.z_offset = -32768;
    for (const std::int64_t y : ys) {
      for (const std::int64_t x : xs) {
        out.vertices.push_back({static_cast<std::int32_t>(x - c.column0), static_cast<std::int32_t>(y - c.row0),
                                static_cast<std::int32_t>(steps(x, y) - out.z_offset)});
      }
    }
    const auto width = static_cast<std::uint32_t>(xs.size());
    for (std::uint32_t j = 0; j + 1 < ys.size(); ++j) {
      for (std::uint32_t i = 0; i + 1 < width; ++i) {
        const double middle_x = static_cast<double>(xs[i] + xs[i + 1]) / 2 * spacing_m;
        const double middle_y = static_cast<double>(ys[j] + ys[j + 1]) / -2 * spacing_m;
        if (hole && hole(middle_x, middle_y)) continue;
        const std::uint32_t nw = j * width + i;
        const std::uint32_t sw = nw + width;
        out.triangles.push_back({nw, sw, nw + 1});
        out.triangles.push_back({nw + 1, sw, sw + 1});
      }
    }
    if (hole) drop_loose_vertices(out);
    return out;
  }

  static void drop_loose_vertices(codec::TileMesh& mesh) {
    std::vector<std::int64_t> place(mesh.vertices.size(), -1);
    std::vector<codec::GridVertex> kept;
    for (codec::Triangle& t : mesh.triangles) {
      for (std::uint32_t& i : t) {
        if (place[i] < 0) {
          place[i] = static_cast<std::int64_t>(kept.size());
          kept.push_back(mesh.vertices[i]);
        }
        i = static_cast<std::uint32_t>(place[i]);
      }
    }
    mesh.vertices = std::move(kept);
  }

  /// Largest difference of the mesh from the samples; `border_only`: of those on the tile's sides.
  double error_m(const codec::TileId& id, bool border_only) const {
    const codec::TreeLayout l = layout();
    const codec::CellRect c = l.cells(id);
    const std::int64_t step = stride(l, id.level);
    double worst = 0;
    for (std::int64_t y = c.row0; y <= c.row1; ++y) {
      for (std::int64_t x = c.column0; x <= c.column1; ++x) {
        const bool border = x == c.column0 || x == c.column1 || y == c.row0 || y == c.row1;
        if (border_only && !border) continue;
        const std::int64_t x0 = std::min(x, c.column1 - 1) / step * step;
        const std::int64_t y0 = std::min(y, c.row1 - 1) / step * step;
        const std::int64_t x1 = std::min(x0 + step, c.column1);
        const std::int64_t y1 = std::min(y0 + step, c.row1);
        const double u = static_cast<double>(x - x0) / static_cast<double>(x1 - x0);
        const double v = static_cast<double>(y - y0) / static_cast<double>(y1 - y0);
        const auto at = [&](std::int64_t i, std::int64_t j) { return static_cast<double>(steps(i, j)); };
        const double z = u + v <= 1
                             ? at(x0, y0) + u * (at(x1, y0) - at(x0, y0)) + v * (at(x0, y1) - at(x0, y0))
                             : at(x1, y1) + (1 - u) * (at(x0, y1) - at(x1, y1)) + (1 - v) * (at(x1, y0) - at(x1, y1));
        worst = std::max(worst, std::abs(z - at(x, y)) * 0.0625);
      }
    }
    return worst + 0.03125;
  }

  cache::TileInfo info(const codec::TileId& id, const codec::TileMesh& m) const {
    cache::TileInfo out;
    out.id = id;
    out.vertices = static_cast<std::uint32_t>(m.vertices.size());
    out.triangles = static_cast<std::uint32_t>(m.triangles.size());
    const auto [low, high] = std::ranges::minmax(m.vertices, {}, &codec::GridVertex::z);
    out.z_min_m = static_cast<double>(low.z + m.z_offset) * 0.0625;
    out.z_max_m = static_cast<double>(high.z + m.z_offset) * 0.0625;
    out.error_m = error_m(id, false);
    out.border_error_m = error_m(id, true);
    out.rms_m = out.error_m;
    return out;
  }

  std::vector<codec::TileId> tiles() const {
    const codec::TreeLayout l = layout();
    std::vector<codec::TileId> out;
    for (int level = 0; level <= l.leaf_level; ++level) {
      for (std::uint32_t y = 0; y < l.tiles_y(level); ++y) {
        for (std::uint32_t x = 0; x < l.tiles_x(level); ++x) {
          if (!hole || !mesh({level, x, y}).triangles.empty()) out.push_back({level, x, y});
        }
      }
    }
    std::ranges::sort(out, {}, &codec::TileId::key);
    return out;
  }

  cache::TileBounds bounds() const {
    std::vector<cache::TileInfo> infos;
    for (const codec::TileId& id : tiles()) infos.push_back(info(id, mesh(id)));
    return {layout(), infos};
  }

  codec::TreeLayout squares() const { return layout().deepened(texture_depth); }

  std::vector<std::byte> texture(const codec::TileId& id) const {
    codec::ColorImage image(texture_size + 1);
    const auto cells = static_cast<double>(squares().cells_across(id.level));
    for (int y = 0; y <= texture_size; ++y) {
      for (int x = 0; x <= texture_size; ++x) {
        const auto [red, green, blue] = photo ? photo(id, (id.x + static_cast<double>(x) / texture_size) * cells,
                                                      (id.y + static_cast<double>(y) / texture_size) * cells)
                                              : color(id);
        const auto i = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture_size + 1) +
                            static_cast<std::size_t>(x));
        image.rgba[i] = red;
        image.rgba[i + 1] = green;
        image.rgba[i + 2] = blue;
        image.rgba[i + 3] = 255;
      }
    }
    return *codec::find_texture_codec("bc1")->encode(image);
  }

  /// A tile's, and those on the squares that a leaf is halved to.
  void put_textures(cache::TileWriter& writer, const codec::TileId& id) const {
    const codec::TreeLayout all = squares();
    if (id != all.picture_tile(id)) return;
    const bool in_leaf = id.level > layout().leaf_level;
    if (!in_leaf || !has_texture || has_texture(id)) {
      const auto put = writer.put_picture(cache::PictureKind::kTexture, id, texture(id));
      ASSERT_TRUE(put) << put.error().text();
    }
    if (all.is_leaf_square(id.level) || all.halvings(id.level) < all.halvings(layout().leaf_level)) return;
    const codec::TileId last{all.coarsest_level(all.halvings(id.level) + 1) - 1, id.x, id.y};
    for (int q = 0; q < 4; ++q) {
      if (const codec::TileId child = all.child(last, q); !all.cells(child).empty()) put_textures(writer, child);
    }
  }

  void write(const std::string& path) const {
    cache::Manifest manifest;
    if (color || photo) {
      manifest.texture_size = texture_size;
      manifest.texture_depth = texture_depth;
      manifest.texture_codec = "bc1";
    }
    manifest.layout = layout();
    manifest.geotransform = geotransform;
    auto writer = cache::TileWriter::create(path, manifest);
    ASSERT_TRUE(writer) << writer.error().text();
    for (const codec::TileId& id : tiles()) {
      const codec::TileMesh m = mesh(id);
      const auto payload = codec::find_codec("tin")->encode(m);
      ASSERT_TRUE(payload) << payload.error().text();
      const auto put = writer->put({info(id, m), *payload});
      ASSERT_TRUE(put) << put.error().text();
      if (color || photo) put_textures(*writer, id);
    }
    const auto digest = writer->finish();
    ASSERT_TRUE(digest) << digest.error().text();
  }
};

}  // namespace tintree::test
