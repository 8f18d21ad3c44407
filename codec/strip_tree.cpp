#include "codec/strip_tree.h"

#include <algorithm>
#include <array>

#include "codec/strip_path.h"

namespace tintree::codec {
namespace {

/// The bit of a triangle with its right angle at `apex` and `doubled` twice the middle of its longest side.
std::uint8_t mark_of(const SplitPoint& apex, const SplitPoint& doubled) {
  const std::int64_t dx = doubled.x - 2 * apex.x;
  const std::int64_t dy = doubled.y - 2 * apex.y;
  const int column = dx < 0 ? 0 : dx == 0 ? 1 : 2;
  const int row = dy < 0 ? 0 : dy == 0 ? 1 : 2;
  static constexpr std::array<std::uint8_t, 9> kBits{1, 2, 4, 8, 0, 16, 32, 64, 128};
  return kBits[static_cast<std::size_t>(3 * row + column)];
}

/// A triangle's corners, the right angle last.
std::array<SplitPoint, 3> corners_of(const StripStep& s) {
  if (s.type == StripType::kC) return {s.v1, s.v2, s.v3};
  if ((s.type == StripType::kB) == s.left) return {s.v1, s.v3, s.v2};
  return {s.v2, s.v3, s.v1};
}

}  // namespace

StripTree::StripTree(int levels, int fine)
    : levels_(levels), fine_(fine), span_(std::int64_t{1} << levels), numbers_(span_) {
  add({span_ / 2, span_ / 2});
  for (const std::int64_t y : {std::int64_t{0}, span_}) {
    for (const std::int64_t x : {std::int64_t{0}, span_}) add({x, y});
  }
}

/// Whether it is new.
bool StripTree::add(const SplitPoint& p) {
  if (is_split(p)) return false;
  numbers_.set(p.x, p.y, static_cast<std::int32_t>(points_.size()));
  points_.emplace_back();
  return true;
}

void StripTree::force(const SplitPoint& p) {
  force_split(
      p, [this](const SplitPoint& at) { return at.x >= 0 && at.y >= 0 && at.x <= span_ && at.y <= span_ && add(at); });
}

/// Puts the heights of the vertices that triangles use on their points.
bool StripTree::place(const TileMesh& mesh) {
  points_.assign(points_.size(), {});
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      std::int32_t& z = at_vertex(i).z;
      if (z != kMissing && z != mesh.vertices[i].z) return false;
      z = mesh.vertices[i].z;
    }
  }
  return std::ranges::all_of(mesh.triangles, [&](const Triangle& t) { return mark(mesh, t); });
}

/// Notes a triangle of the mesh; false when it is none of the tree's.
bool StripTree::mark(const TileMesh& mesh, const Triangle& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto place = [&](std::size_t corner) {
      const GridVertex& v = mesh.vertices[t[corner % 3]];
      return SplitPoint{std::int64_t{v.x} << fine_, std::int64_t{v.y} << fine_};
    };
    const SplitPoint c = place(k);
    const SplitPoint a{place(k + 1).x - c.x, place(k + 1).y - c.y};
    const SplitPoint b{place(k + 2).x - c.x, place(k + 2).y - c.y};
    // From a to b is a quarter turn counter-clockwise.
    if (b.x != a.y || b.y != -a.x) continue;
    const SplitPoint doubled{2 * c.x + a.x + b.x, 2 * c.y + a.y + b.y};
    // The same in half steps, where every middle is a point.
    const auto parents = split_parents(doubled);
    if (std::ranges::find(parents, SplitPoint{2 * c.x, 2 * c.y}) == parents.end()) return false;
    if (((doubled.x | doubled.y) & 1) == 0 && is_split({doubled.x / 2, doubled.y / 2})) return false;
    std::uint8_t& marks = at_vertex(t[k]).marks;
    const std::uint8_t bit = mark_of(c, doubled);
    const bool fresh = (marks & bit) == 0;
    marks |= bit;
    return fresh;
  }
  return false;
}

/// Splits triangles that have all their vertices but are not in the mesh. False where one cannot be split, or where
/// none is left and the mesh has others than the tree's.
bool StripTree::split_false_triangles(std::size_t wanted, bool& changed) {
  std::vector<SplitPoint> splits;
  std::size_t found = 0;
  bool possible = true;
  triangles_ = 0;
  walk_strip(
      span_, [this](const SplitPoint& p) { return is_split(p); },
      [&](const StripStep& s) {
        ++triangles_;
        const auto [a, b, c] = corners_of(s);
        const Point& apex = at(c);
        if (apex.z == kMissing || z(a) == kMissing || z(b) == kMissing) return;
        const SplitPoint doubled{a.x + b.x, a.y + b.y};
        if ((apex.marks & mark_of(c, doubled)) != 0) {
          ++found;
        } else if (((doubled.x | doubled.y) & 1) != 0) {
          possible = false;
        } else {
          splits.push_back({doubled.x / 2, doubled.y / 2});
        }
      });
  for (const SplitPoint& p : splits) force(p);
  changed = !splits.empty();
  holes_ = triangles_ > wanted;
  return possible && (changed || found == wanted);
}

std::optional<StripTree> StripTree::find(const TileMesh& mesh, int levels, int fine) {
  StripTree tree(levels, fine);
  tree.of_vertex_.assign(mesh.vertices.size(), kNoPoint);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      if (tree.of_vertex_[i] != kNoPoint) continue;
      const SplitPoint at{std::int64_t{mesh.vertices[i].x} << fine, std::int64_t{mesh.vertices[i].y} << fine};
      tree.force(at);
      tree.of_vertex_[i] = tree.numbers_.get(at.x, at.y);
    }
  }
  for (bool changed = true; changed;) {
    if (!tree.place(mesh) || !tree.split_false_triangles(mesh.triangles.size(), changed)) return std::nullopt;
  }
  return tree;
}

}  // namespace tintree::codec
