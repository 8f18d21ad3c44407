#include "tests/apps/audit/random_tin.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace tintree::test {
namespace {

/// Triangles by hash: slow and simple.
class LooseMesh {
 public:
  LooseMesh(codec::TileMesh mesh, std::int32_t width, std::int32_t height)
      : mesh_(std::move(mesh)), width_(width), height_(height) {}

  bool on_side(std::uint32_t v) const {
    const codec::GridVertex& p = mesh_.vertices[v];
    return p.x == 0 || p.y == 0 || p.x == width_ || p.y == height_;
  }

  std::vector<std::size_t> around(std::uint32_t v) const {
    std::vector<std::size_t> out;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (std::ranges::count(mesh_.triangles[t], v) > 0) out.push_back(t);
    }
    return out;
  }

  /// Collapses v onto a neighbour if all triangles stay proper.
  void try_collapse(std::uint32_t v, std::mt19937_64& random) {
    const auto star = around(v);
    if (star.empty()) return;
    std::set<std::uint32_t> ring;
    for (const std::size_t t : star) ring.insert(mesh_.triangles[t].begin(), mesh_.triangles[t].end());
    ring.erase(v);
    const std::uint32_t goal = *std::next(ring.begin(), static_cast<std::ptrdiff_t>(random() % ring.size()));
    std::vector<codec::Triangle> changed;
    for (const std::size_t t : star) {
      codec::Triangle n = mesh_.triangles[t];
      if (std::ranges::count(n, goal) > 0) continue;
      std::ranges::replace(n, v, goal);
      if (codec::doubled_area(mesh_.vertices[n[0]], mesh_.vertices[n[1]], mesh_.vertices[n[2]]) <= 0) return;
      changed.push_back(n);
    }
    if (star.size() - changed.size() != 2) return;
    for (auto it = star.rbegin(); it != star.rend(); ++it) {
      mesh_.triangles.erase(mesh_.triangles.begin() + static_cast<std::ptrdiff_t>(*it));
    }
    mesh_.triangles.insert(mesh_.triangles.end(), changed.begin(), changed.end());
  }

  void try_move(std::uint32_t v, std::mt19937_64& random) {
    const codec::GridVertex before = mesh_.vertices[v];
    mesh_.vertices[v].x += static_cast<std::int32_t>(random() % 7) - 3;
    mesh_.vertices[v].y += static_cast<std::int32_t>(random() % 7) - 3;
    for (const std::size_t t : around(v)) {
      const codec::Triangle& n = mesh_.triangles[t];
      if (codec::doubled_area(mesh_.vertices[n[0]], mesh_.vertices[n[1]], mesh_.vertices[n[2]]) > 0) continue;
      mesh_.vertices[v] = before;
      return;
    }
  }

  codec::TileMesh compact() const {
    codec::TileMesh out{mesh_.xy_shift, mesh_.z_offset, {}, mesh_.triangles};
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (codec::Triangle& t : out.triangles) {
      for (std::uint32_t& v : t) {
        const auto [at, added] = numbers.try_emplace(v, static_cast<std::uint32_t>(out.vertices.size()));
        if (added) out.vertices.push_back(mesh_.vertices[v]);
        v = at->second;
      }
    }
    return out;
  }

 private:
  codec::TileMesh mesh_;
  std::int32_t width_;
  std::int32_t height_;
};

}  // namespace

codec::TileMesh random_tin(const HeightGrid& grid, const codec::TreeLayout& layout, const codec::TileId& id,
                           int fine_shift, double noise_m, std::uint64_t seed) {
  const codec::CellRect cells = layout.cells(id);
  const double step = layout.z_step_m[static_cast<std::size_t>(id.level)];
  const std::int32_t scale = 1 << -fine_shift;
  const auto width = static_cast<std::int32_t>(cells.column1 - cells.column0);
  const auto height = static_cast<std::int32_t>(cells.row1 - cells.row0);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> noise(-noise_m, noise_m);
  codec::TileMesh mesh;
  mesh.xy_shift = fine_shift;
  mesh.z_offset = -30000;
  for (std::int32_t r = 0; r <= height; ++r) {
    for (std::int32_t c = 0; c <= width; ++c) {
      const double z = grid.at(cells.column0 + c, cells.row0 + r) + noise(random);
      mesh.vertices.push_back({c * scale, r * scale, static_cast<std::int32_t>(std::lround(z / step) + 30000)});
    }
  }
  const auto number = [width](std::int32_t c, std::int32_t r) {
    return static_cast<std::uint32_t>(r * (width + 1) + c);
  };
  for (std::int32_t r = 0; r < height; ++r) {
    for (std::int32_t c = 0; c < width; ++c) {
      mesh.triangles.push_back({number(c, r), number(c, r + 1), number(c + 1, r + 1)});
      mesh.triangles.push_back({number(c, r), number(c + 1, r + 1), number(c + 1, r)});
    }
  }
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  LooseMesh loose(std::move(mesh), width * scale, height * scale);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (loose.on_side(v)) continue;
    if (random() % 4 != 0) loose.try_collapse(v, random);
  }
  for (std::uint32_t v = 0; fine_shift < 0 && v < count; ++v) {
    if (!loose.on_side(v)) loose.try_move(v, random);
  }
  return loose.compact();
}

}  // namespace tintree::test
