#include "codec/triangle_fans.h"

#include <algorithm>
#include <array>

namespace tintree::codec {
namespace {

/// The triangles at each vertex, one list behind the other.
struct Incidence {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> triangles;

  Incidence(std::span<const Triangle> all, std::size_t vertices) : begin(vertices + 1), triangles(3 * all.size()) {
    for (const Triangle& t : all) {
      for (const std::uint32_t v : t) ++begin[v + 1];
    }
    for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      for (const std::uint32_t v : all[i]) triangles[next[v]++] = i;
    }
  }
  std::span<const std::uint32_t> at(std::uint32_t v) const {
    return std::span(triangles).subspan(begin[v], begin[v + 1] - begin[v]);
  }
};

/// A triangle seen from the hub: counter-clockwise from `first` to `last`.
struct Spread {
  std::uint32_t first;
  std::uint32_t last;
};

}  // namespace

std::vector<std::uint32_t> triangle_fans(std::span<const Triangle> triangles, std::span<const std::uint32_t> hubs,
                                         std::size_t vertices, std::uint32_t restart) {
  const Incidence incidence(triangles, vertices);
  std::vector<bool> done(triangles.size());
  std::vector<std::uint32_t> out;
  out.reserve(2 * triangles.size());
  std::vector<Spread> round;
  for (const std::uint32_t hub : hubs) {
    round.clear();
    for (const std::uint32_t i : incidence.at(hub)) {
      if (done[i]) continue;
      done[i] = true;
      const Triangle& t = triangles[i];
      const std::size_t k = t[0] == hub ? 0 : t[1] == hub ? 1 : 2;
      round.push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
    }
    while (!round.empty()) {
      // Begin where nothing leads to, if there is such a place.
      auto at = std::ranges::find_if(
          round, [&](const Spread& s) { return std::ranges::find(round, s.first, &Spread::last) == round.end(); });
      if (at == round.end()) at = round.begin();
      out.insert(out.end(), {hub, at->first});
      for (; at != round.end(); at = std::ranges::find(round, out.back(), &Spread::first)) {
        out.push_back(at->last);
        round.erase(at);
      }
      out.push_back(restart);
    }
  }
  return out;
}

}  // namespace tintree::codec
