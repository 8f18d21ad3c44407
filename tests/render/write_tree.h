#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cache/tile_store.h"
#include "codec/mesh_codec.h"
#include "codec/normal_codec.h"

namespace tintree::test {

/// What a normal map is to say at a place of the tree, metres east and north of its first sample.
using NormalAt = std::function<std::array<float, 3>(double x_m, double y_m)>;

/// Not what any ground says.
inline std::array<float, 3> ripples(double x, double y) {
  const double east = 0.5 * std::sin(x / 37);
  const double north = 0.5 * std::cos(y / 29);
  const double length = std::sqrt(east * east + north * north + 1);
  return {static_cast<float>(east / length), static_cast<float>(north / length), static_cast<float>(1 / length)};
}

inline std::vector<std::byte> normal_map(const codec::TreeLayout& layout, const codec::TileId& id,
                                         const NormalAt& normal_at) {
  codec::NormalImage image(layout.tile_cells + 1);
  const double texel_m = layout.dx_m * static_cast<double>(layout.cells_across(id.level)) / layout.tile_cells;
  for (int y = 0; y < image.size; ++y) {
    for (int x = 0; x < image.size; ++x)
      image.at(x, y) = normal_at((id.x * layout.tile_cells + x) * texel_m, -(id.y * layout.tile_cells + y) * texel_m);
  }
  return codec::encode_normals(image);
}

/// Writes the meshes of a tree (AnalyticTree, NestedTree) by any method, with its textures if it has any, and with
/// normal maps if there are to be some. `geotransform`: where it lies.
template <typename Tree>
void write_tree(const std::string& path, const std::string& method, const codec::MeshCodec& codec, const Tree& tree,
                const NormalAt& normal_at = nullptr, const std::array<double, 6>& geotransform = {}) {
  cache::Manifest manifest;
  manifest.method = method;
  manifest.layout = tree.layout();
  manifest.geotransform = geotransform;
  manifest.normal_maps = normal_at != nullptr;
  bool textured = false;
  if constexpr (requires { tree.color; }) {
    textured = tree.color != nullptr;
    manifest.texture_size = textured ? tree.texture_size : 0;
    if (textured) manifest.texture_codec = "bc1";
  }
  auto writer = cache::TileWriter::create(path, manifest);
  ASSERT_TRUE(writer) << writer.error().text();
  for (const codec::TileId& id : tree.tiles()) {
    const codec::TileMesh m = tree.mesh(id);
    const auto payload = codec.encode(m);
    ASSERT_TRUE(payload) << payload.error().text();
    ASSERT_TRUE(writer->put({tree.info(id, m), *payload}));
    if constexpr (requires { tree.color; }) {
      if (textured) {
        ASSERT_TRUE(writer->put_picture(cache::PictureKind::kTexture, id, tree.texture(id)));
      }
    }
    if (normal_at) {
      ASSERT_TRUE(writer->put_picture(cache::PictureKind::kNormal, id, normal_map(manifest.layout, id, normal_at)));
    }
  }
  ASSERT_TRUE(writer->finish());
}

}  // namespace tintree::test
