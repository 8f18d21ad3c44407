#include "codec/vertex_fans.h"

#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tintree::codec {
namespace {

/// The corners of all triangles, three each in order, in sets.
class CornerSets {
 public:
  explicit CornerSets(std::size_t count) : above_(count) { std::iota(above_.begin(), above_.end(), std::size_t{0}); }

  std::size_t root(std::size_t corner) {
    while (above_[corner] != corner) corner = above_[corner] = above_[above_[corner]];
    return corner;
  }
  void join(std::size_t a, std::size_t b) { above_[root(a)] = root(b); }

 private:
  std::vector<std::size_t> above_;
};

}  // namespace

void separate_fans(TileMesh& mesh) {
  CornerSets sets(3 * mesh.triangles.size());
  std::unordered_map<std::uint64_t, std::size_t> edges;  // from -> to: the corner at `from`
  const auto key = [](std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; };
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const std::uint32_t from = mesh.triangles[t][k];
      const std::uint32_t to = mesh.triangles[t][next];
      edges[key(from, to)] = 3 * t + k;
      const auto twin = edges.find(key(to, from));
      if (twin == edges.end()) continue;
      const std::size_t other = twin->second;  // the corner at `to`; the one at `from` is the next of its triangle
      sets.join(3 * t + next, other);
      sets.join(3 * t + k, other - other % 3 + (other % 3 + 1) % 3);
    }
  }
  std::unordered_map<std::size_t, std::uint32_t> vertex_of;
  std::vector<bool> taken(mesh.vertices.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& corner = mesh.triangles[t][k];
      const auto [at, fresh] = vertex_of.try_emplace(sets.root(3 * t + k), corner);
      if (fresh && taken[corner]) {
        at->second = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(GridVertex(mesh.vertices[corner]));
      } else if (fresh) {
        taken[corner] = true;
      }
      corner = at->second;
    }
  }
}

}  // namespace tintree::codec
