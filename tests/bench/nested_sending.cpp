/// nested_sending TREE: what the leaves of a tree of method `nested` cost on their way, level by level: as the blocks
/// of their payloads, each level only what is new, and as each level sent whole by the same coder; the same for the
/// graphics card (12 bytes a vertex: address, height and eight morphs; 2 bytes an index). Also what decoding takes.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "cache/tile_store.h"
#include "codec/nested_payload.h"
#include "codec/nested_tile.h"

namespace {

using namespace tintree;

constexpr std::size_t kVertexBytes = 12;
constexpr std::size_t kIndexBytes = 2;

struct LevelCost {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t indices = 0;
  std::size_t new_bytes = 0;    ///< Its block.
  std::size_t whole_bytes = 0;  ///< All its points, coded as one block.
  std::size_t new_card_bytes = 0;
  std::size_t whole_card_bytes = 0;
};

std::size_t whole_bytes(const codec::NestedPayload& payload, int level) {
  codec::NestedPoints points(payload.side_bits);
  const auto all = codec::read_points(payload, level + 1);
  for (codec::NestedPoint p : all->points()) {
    p.level = 0;
    points.add(p);
  }
  codec::NestedPoints written(payload.side_bits);
  return codec::write_nested(payload.xy_shift, payload.z_offset, payload.side_bits, 1, points, written)->size();
}

int fail(const Error& error) {
  std::fprintf(stderr, "%s\n", error.text().c_str());
  return static_cast<int>(error.code);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: nested_sending TREE\n");
    return 2;
  }
  const auto store = cache::TileStore::open(argv[1]);
  if (!store) return fail(store.error());
  std::vector<LevelCost> levels;
  double seconds = 0;
  for (const cache::TileNode& node : store->bounds().nodes()) {
    if (node.id.level != store->manifest().layout.leaf_level) continue;
    const auto stored = store->read(node.id);
    if (!stored) return fail(stored.error());
    const auto begin = std::chrono::steady_clock::now();
    const auto tile = codec::decode_nested(stored->payload);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto payload = codec::parse_nested(stored->payload, codec::NestedTile::kMostLevels);
    if (!tile || !payload) return fail(tile ? payload.error() : tile.error());
    levels.resize(std::max(levels.size(), static_cast<std::size_t>(tile->levels)));
    for (int i = 0; i < tile->levels; ++i) {
      const auto k = static_cast<std::size_t>(i);
      LevelCost& cost = levels[k];
      const std::size_t vertices = tile->level_vertices[k];
      const std::size_t index_bytes = kIndexBytes * tile->fans[k].size();
      cost.vertices += vertices;
      cost.triangles += tile->level_triangles[k];
      cost.indices += tile->fans[k].size();
      cost.new_bytes += payload->block_bytes[k] + (i == 0 ? payload->header_bytes : 0);
      cost.whole_bytes += whole_bytes(*payload, i);
      cost.new_card_bytes += kVertexBytes * (vertices - (i == 0 ? 0 : tile->level_vertices[k - 1])) + index_bytes;
      cost.whole_card_bytes += kVertexBytes * vertices + index_bytes;
    }
  }
  std::printf("level vertices triangles indices/triangle block whole card_new card_whole\n");
  LevelCost sum;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const LevelCost& c = levels[k];
    std::printf("%zu %zu %zu %.2f %zu %zu %zu %zu\n", k, c.vertices, c.triangles,
                static_cast<double>(c.indices) / static_cast<double>(c.triangles), c.new_bytes, c.whole_bytes,
                c.new_card_bytes, c.whole_card_bytes);
    sum.new_bytes += c.new_bytes;
    sum.whole_bytes += c.whole_bytes;
    sum.new_card_bytes += c.new_card_bytes;
    sum.whole_card_bytes += c.whole_card_bytes;
  }
  std::printf(
      "all: block %zu whole %zu (%.2f), card_new %zu card_whole %zu (%.2f); decoded in %.3f s, %.2f M vertices/s\n",
      sum.new_bytes, sum.whole_bytes, static_cast<double>(sum.whole_bytes) / static_cast<double>(sum.new_bytes),
      sum.new_card_bytes, sum.whole_card_bytes,
      static_cast<double>(sum.whole_card_bytes) / static_cast<double>(sum.new_card_bytes), seconds,
      static_cast<double>(levels.back().vertices) / seconds / 1e6);
  return 0;
}
