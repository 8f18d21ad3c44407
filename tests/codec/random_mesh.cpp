#include "tests/codec/random_mesh.h"

#include <algorithm>
#include <numeric>

namespace tintree::test {
namespace {

using codec::GridVertex;
using codec::TileMesh;

bool chance(std::mt19937& random, double p) { return std::uniform_real_distribution<>(0, 1)(random) < p; }

/// Gives the mesh only the vertices that its triangles use, in random order.
void shuffle_vertices(std::mt19937& random, TileMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    for (const auto v : t) used[v] = true;
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v]) order.push_back(v);
  }
  std::ranges::shuffle(order, random);
  std::vector<GridVertex> vertices;
  std::vector<std::uint32_t> place(used.size());
  for (const auto v : order) {
    place[v] = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(mesh.vertices[v]);
  }
  mesh.vertices = std::move(vertices);
  for (auto& t : mesh.triangles) {
    for (auto& v : t) v = place[v];
  }
}

}  // namespace

TileMesh random_mesh(std::mt19937& random, const MeshSpec& spec) {
  TileMesh mesh;
  mesh.xy_shift = spec.xy_shift;
  mesh.z_offset = spec.z_offset;
  std::uniform_int_distribution<std::int32_t> height(0, spec.height_range);
  for (int y = 0; y <= spec.rows; ++y) {
    for (int x = 0; x <= spec.columns; ++x) mesh.vertices.push_back({x, y, height(random)});
  }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (spec.columns + 1) + x); };
  for (int y = 0; y < spec.rows; ++y) {
    for (int x = 0; x < spec.columns; ++x) {
      const auto nw = at(x, y);
      const auto ne = at(x + 1, y);
      const auto sw = at(x, y + 1);
      const auto se = at(x + 1, y + 1);
      if (!chance(random, spec.drop)) mesh.triangles.push_back({nw, sw, se});
      if (!chance(random, spec.drop)) mesh.triangles.push_back({nw, se, ne});
    }
  }
  if (mesh.triangles.empty()) mesh.triangles.push_back({at(0, 0), at(0, 1), at(1, 1)});
  for (auto& t : mesh.triangles) {
    std::ranges::rotate(t, t.begin() + static_cast<int>(random() % 3));
    for (auto& v : t) {
      if (!chance(random, spec.split)) continue;
      mesh.vertices.push_back(mesh.vertices[v]);
      v = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    }
  }
  std::ranges::shuffle(mesh.triangles, random);
  shuffle_vertices(random, mesh);
  return mesh;
}

std::vector<std::array<std::array<std::int64_t, 3>, 3>> triangle_set(const TileMesh& mesh) {
  std::vector<std::array<std::array<std::int64_t, 3>, 3>> out;
  for (const auto& t : mesh.triangles) {
    std::array<std::array<std::int64_t, 3>, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const GridVertex& v = mesh.vertices[t[k]];
      corners[k] = {v.x, v.y, mesh.z_offset + v.z};
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    out.push_back(corners);
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace tintree::test
