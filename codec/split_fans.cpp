#include "codec/split_fans.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tintree::codec {
namespace {

/// A triangle's corner at a vertex: the vertices after and before it, counter-clockwise.
struct Corner {
  std::uint32_t* vertex;
  std::uint32_t next;
  std::uint32_t previous;
  bool taken = false;
};

/// Takes the corners of one fan, to both sides of `seed`, and gives them a vertex.
void take_fan(std::vector<Corner>& corners, std::size_t seed, std::uint32_t vertex) {
  std::uint32_t ahead = corners[seed].previous;
  std::uint32_t behind = corners[seed].next;
  corners[seed].taken = true;
  *corners[seed].vertex = vertex;
  for (bool grown = true; grown;) {
    grown = false;
    for (Corner& c : corners) {
      if (c.taken || (c.next != ahead && c.previous != behind)) continue;
      if (c.next == ahead) {
        ahead = c.previous;
      } else {
        behind = c.next;
      }
      c.taken = grown = true;
      *c.vertex = vertex;
    }
  }
}

}  // namespace

void split_fans(TileMesh& mesh) {
  std::vector<std::uint32_t> start(mesh.vertices.size() + 1);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) ++start[v + 1];
  }
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
  std::vector<std::uint32_t> incident(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) incident[fill[v]++] = t;
  }
  const std::size_t count = mesh.vertices.size();
  const std::vector<Triangle> before = mesh.triangles;
  std::vector<Corner> corners;
  for (std::uint32_t v = 0; v < count; ++v) {
    corners.clear();
    for (std::uint32_t i = start[v]; i < start[v + 1]; ++i) {
      const Triangle& t = before[incident[i]];
      const auto k = static_cast<std::size_t>(std::ranges::find(t, v) - t.begin());
      corners.push_back({&mesh.triangles[incident[i]][k], t[(k + 1) % 3], t[(k + 2) % 3]});
    }
    bool first = true;
    for (std::size_t seed = 0; seed < corners.size(); ++seed) {
      if (corners[seed].taken) continue;
      std::uint32_t vertex = v;
      if (!first) {
        vertex = static_cast<std::uint32_t>(mesh.vertices.size());
        const GridVertex again = mesh.vertices[v];
        mesh.vertices.push_back(again);
      }
      take_fan(corners, seed, vertex);
      first = false;
    }
  }
}

}  // namespace tintree::codec
