#include "tests/codec/random_quadtree.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "codec/split_fans.h"

namespace tintree::test {
namespace {

using Place = std::pair<int, int>;
using Corners = std::array<Place, 3>;  // longest side from 0 to 1

Place middle(const Place& a, const Place& b) { return {(a.first + b.first) / 2, (a.second + b.second) / 2}; }
bool whole(const Place& a, const Place& b) { return (a.first + b.first) % 2 == 0 && (a.second + b.second) % 2 == 0; }

bool inside(const Corners& t, const Place& p) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& [ax, ay] = t[k];
    const auto& [bx, by] = t[(k + 1) % 3];
    if (std::int64_t{bx - ax} * (p.second - ay) - std::int64_t{p.first - ax} * (by - ay) > 0) return false;
  }
  return true;
}

/// Bisects what `wanted` asks for; true when something was.
template <typename Wanted>
bool bisect(std::vector<Corners>& mesh, const Wanted& wanted) {
  std::vector<Corners> out;
  for (const Corners& t : mesh) {
    const Place m = middle(t[0], t[1]);
    if (whole(t[0], t[1]) && wanted(t)) {
      out.push_back({t[2], t[0], m});
      out.push_back({t[1], t[2], m});
    } else {
      out.push_back(t);
    }
  }
  const bool changed = out.size() > mesh.size();
  mesh = std::move(out);
  return changed;
}

}  // namespace

codec::TileMesh random_quadtree(std::mt19937& random, const QuadtreeSpec& spec) {
  const int n = 1 << spec.levels;
  const Place centre{n / 2, n / 2};
  std::vector<Corners> mesh{
      {{{n, 0}, {0, 0}, centre}}, {{{0, 0}, {0, n}, centre}}, {{{0, n}, {n, n}, centre}}, {{{n, n}, {n, 0}, centre}}};
  for (int k = 0; k < spec.splits; ++k) {
    const Place p{static_cast<int>(random() % static_cast<unsigned>(n + 1)),
                  static_cast<int>(random() % static_cast<unsigned>(n + 1))};
    const auto depth = random() % static_cast<unsigned>(2 * spec.levels + 1);
    for (unsigned d = 0; d < depth; ++d) {
      bool once = true;
      bisect(mesh, [&](const Corners& t) { return inside(t, p) && std::exchange(once, false); });
    }
  }
  // A side with a vertex in its middle makes its triangle split, whichever side it is.
  for (bool changed = true; changed;) {
    std::map<Place, bool> vertices;
    for (const Corners& t : mesh) {
      for (const Place& p : t) vertices[p] = true;
    }
    changed = bisect(mesh, [&](const Corners& t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Place& a = t[k];
        const Place& b = t[(k + 1) % 3];
        if (whole(a, b) && vertices.contains(middle(a, b))) return true;
      }
      return false;
    });
  }
  codec::TileMesh out;
  std::map<Place, std::int64_t> index;
  const auto chance = [&] { return static_cast<double>(random() % 10000) / 10000; };
  for (const Corners& t : mesh) {
    for (const Place& p : t) {
      if (!index.contains(p)) index[p] = chance() < spec.missing ? -1 : -2;
    }
  }
  for (const Corners& t : mesh) {
    if (std::ranges::any_of(t, [&](const Place& p) { return index[p] == -1; })) continue;
    codec::Triangle& triangle = out.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      std::int64_t& i = index[t[k]];
      if (i == -2) {
        i = static_cast<std::int64_t>(out.vertices.size());
        const auto steps = static_cast<unsigned>(spec.height_range / spec.height_unit + 1);
        out.vertices.push_back({t[k].first, t[k].second, spec.height_unit * static_cast<int>(random() % steps)});
      }
      triangle[k] = static_cast<std::uint32_t>(i);
    }
    std::ranges::rotate(triangle, triangle.begin() + random() % 3);
  }
  std::ranges::shuffle(out.triangles, random);
  codec::split_fans(out);
  return out;
}

}  // namespace tintree::test
