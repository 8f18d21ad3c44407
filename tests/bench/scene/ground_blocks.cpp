#include "tests/bench/scene/ground_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/grid_frame.h"

namespace tintree::bench {
namespace {

/// Column, row, height in metres.
using Place = glm::dvec3;
using Corners = std::array<Place, 3>;

class Spreader {
 public:
  explicit Spreader(const codec::TreeLayout& layout) : layout_(layout) {
    blocks_.columns = (layout.columns - 2) / kBlockCells + 1;
    blocks_.rows = (layout.rows - 2) / kBlockCells + 1;
    const auto count = static_cast<std::size_t>(blocks_.columns * blocks_.rows);
    blocks_.triangles.resize(count);
    blocks_.cells.resize(count);
    blocks_.centres.resize(count);
  }

  void add(const Corners& t) {
    const Place a = t[1] - t[0];
    const Place b = t[2] - t[0];
    const Place c = b - a;
    const double longest = std::max({std::hypot(a.x, a.y), std::hypot(b.x, b.y), std::hypot(c.x, c.y)});
    const int parts = std::max(1, static_cast<int>(std::ceil(longest / (0.5 * kBlockCells))));
    const double share = 1.0 / (static_cast<double>(parts) * parts);
    const double cells = 0.5 * std::abs(a.x * b.y - a.y * b.x) * share;
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; i + j < parts; ++j) {
        part(t[0] + (a * (i + 1.0 / 3) + b * (j + 1.0 / 3)) / static_cast<double>(parts), share, cells);
        if (i + j + 1 < parts)
          part(t[0] + (a * (i + 2.0 / 3) + b * (j + 2.0 / 3)) / static_cast<double>(parts), share, cells);
      }
    }
  }

  GroundBlocks result() && {
    for (std::size_t i = 0; i < blocks_.cells.size(); ++i) {
      if (blocks_.cells[i] <= 0) continue;
      const Place middle = blocks_.centres[i] / blocks_.cells[i];
      const auto [x, y] = layout_.world(middle.x, middle.y);
      blocks_.centres[i] = {x, y, middle.z};
    }
    return std::move(blocks_);
  }

 private:
  void part(const Place& middle, double share, double cells) {
    const auto column = static_cast<std::int64_t>(middle.x) / kBlockCells;
    const auto row = static_cast<std::int64_t>(middle.y) / kBlockCells;
    const auto i = static_cast<std::size_t>(std::min(row, blocks_.rows - 1) * blocks_.columns +
                                            std::min(column, blocks_.columns - 1));
    blocks_.triangles[i] += share;
    blocks_.cells[i] += cells;
    blocks_.centres[i] += cells * middle;
  }

  const codec::TreeLayout& layout_;
  GroundBlocks blocks_;
};

}  // namespace

Expected<GroundBlocks> ground_blocks(const cache::TileStore& store, int level) {
  const codec::TreeLayout& layout = store.bounds().layout();
  Spreader spreader(layout);
  for (const cache::TileNode& node : store.bounds().nodes()) {
    if (node.id.level != level) continue;
    const auto mesh = store.read_mesh(node.id);
    if (!mesh) return tl::unexpected(mesh.error());
    const codec::GridFrame frame(layout, node.id, *mesh);
    const auto place = [&](std::uint32_t v) {
      const codec::GridVertex& g = mesh->vertices[v];
      return Place(frame.column(g.x), frame.row(g.y), frame.height_m(g.z));
    };
    for (const codec::Triangle& t : mesh->triangles) spreader.add({place(t[0]), place(t[1]), place(t[2])});
  }
  return std::move(spreader).result();
}

}  // namespace tintree::bench
