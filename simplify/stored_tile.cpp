#include "simplify/stored_tile.h"

#include <algorithm>
#include <utility>

namespace tintree::simplify {

using codec::TileId;

namespace {

void append_tiles(const codec::TreeLayout& layout, const TileId& id, std::vector<TileId>& out) {
  if (layout.cells(id).empty()) return;
  if (id.level < layout.leaf_level) {
    for (int i = 0; i < layout.child_count(id.level); ++i) append_tiles(layout, layout.child(id, i), out);
  }
  out.push_back(id);
}

}  // namespace

std::vector<TileId> list_tiles(const codec::TreeLayout& layout) {
  std::vector<TileId> tiles;
  append_tiles(layout, {0, 0, 0}, tiles);
  return tiles;
}

Expected<cache::StoredTile> make_stored_tile(TileMaker& maker, const codec::MeshCodec& codec,
                                             const codec::TreeLayout& layout, const TileId& id) {
  auto mesh = maker.make(id);
  if (!mesh) return tl::unexpected(mesh.error());
  cache::StoredTile tile;
  tile.info.id = id;
  if (mesh->triangles.empty()) return tile;
  auto payload = maker.encode(codec, id, *mesh);
  if (!payload) {
    payload.error().where = "tile " + id.text();
    return tl::unexpected(payload.error());
  }
  tile.payload = std::move(*payload);
  const codec::GridFrame frame(layout, id, *mesh);
  const auto [lowest, highest] = std::ranges::minmax(mesh->vertices, {}, &codec::GridVertex::z);
  tile.info.z_min_m = frame.height_m(lowest.z);
  tile.info.z_max_m = frame.height_m(highest.z);
  tile.info.vertices = static_cast<std::uint32_t>(mesh->vertices.size());
  tile.info.triangles = static_cast<std::uint32_t>(mesh->triangles.size());
  return tile;
}

}  // namespace tintree::simplify
