#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <vector>

#include "codec/tile_mesh.h"

namespace tintree::codec {

/// The loops between the triangles that are known and those that are still to come, which lie to the left: the front of
/// a mesh that grows triangle by triangle (Gumhold, Strasser 1998, "cut border"). A node is a vertex on a loop and the
/// edge from there to the next node's.
class TinFront {
 public:
  using Index = std::uint32_t;
  static constexpr Index kNone = UINT32_MAX;
  static constexpr std::int8_t kStale = -1;

  struct Node {
    std::uint32_t vertex = 0;
    Index next = 0;
    Index previous = 0;
    std::int32_t half = 0;  ///< Of the triangle to come (TinSource), for who knows it.
    bool open = true;       ///< Whether a triangle may come there.
    bool gone = false;
    std::int8_t turn = kStale;  ///< As turn() has it.
  };

  /// `points` are the vertices by number.
  explicit TinFront(const std::vector<GridVertex>& points) : points_(&points) {}

  const Node& operator[](Index i) const { return nodes_[i]; }
  const GridVertex& point(Index i) const { return (*points_)[nodes_[i].vertex]; }

  /// A node between two.
  Index insert(std::uint32_t vertex, std::int32_t half, Index previous, Index next) {
    const auto i = static_cast<Index>(nodes_.size());
    nodes_.push_back({vertex, next, previous, half});
    if (previous != kNone) link(previous, i, nodes_[previous].half);
    if (next != kNone) link(i, next, half);
    const GridVertex& p = point(i);
    order_.push({static_cast<std::uint64_t>(p.y) << 32 | static_cast<std::uint32_t>(p.x), i});
    return i;
  }
  /// Makes `b` follow `a`, by an edge with this triangle to come.
  void link(Index a, Index b, std::int32_t half) {
    nodes_[a].next = b;
    nodes_[a].half = half;
    nodes_[b].previous = a;
    nodes_[a].turn = nodes_[b].turn = kStale;
  }
  void close(Index i) { nodes_[i].open = false; }
  void remove(Index i) { nodes_[i].gone = true; }

  /// The edge to go on at: that of the northernmost node with an open one, or where it or a node next to it is a sharp
  /// corner, the sharpest of them. kNone if there is none.
  Index gate() {
    while (!order_.empty() && !live(order_.top().node)) order_.pop();
    if (order_.empty()) return kNone;
    const Index first = order_.top().node;
    Index best = first;
    int sharpest = turn(first);
    for (const Index i : {nodes_[first].next, nodes_[first].previous}) {
      if (!live(i) || turn(i) >= sharpest) continue;
      best = i;
      sharpest = turn(i);
    }
    return sharpest < kBluntTurn ? best : first;
  }

  static constexpr std::size_t kTurns = 8;
  /// The angle that a node leaves for triangles: 0 up to 45 degrees, 1 to 63, 2 to 90, 3 less than 117, 4 to 135, 5
  /// to 180, 6 more, 7 none or straight.
  int turn(Index i) {
    std::int8_t& known = nodes_[i].turn;
    if (known == kStale) known = find_turn(nodes_[i]);
    return known;
  }

 private:
  static constexpr int kBluntTurn = 2;

  struct Entry {
    std::uint64_t place = 0;
    Index node = 0;
    bool operator>(const Entry& o) const { return place != o.place ? place > o.place : node > o.node; }
  };

  bool live(Index i) const { return nodes_[i].open && !nodes_[i].gone; }
  std::int8_t find_turn(const Node& node) const {
    const GridVertex& c = (*points_)[node.vertex];
    const GridVertex& n = point(node.next);
    const GridVertex& p = point(node.previous);
    const std::int64_t sine = doubled_area(c, n, p);
    const std::int64_t cosine = std::int64_t{n.x - c.x} * (p.x - c.x) + std::int64_t{n.y - c.y} * (p.y - c.y);
    if (sine <= 0) return cosine < 0 ? 6 : 7;
    if (cosine > 0) return sine <= cosine ? 0 : sine <= 2 * cosine ? 1 : 2;
    return sine >= -2 * cosine ? 3 : sine >= -cosine ? 4 : 5;
  }

  const std::vector<GridVertex>* points_;
  std::vector<Node> nodes_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> order_;
};

}  // namespace tintree::codec
