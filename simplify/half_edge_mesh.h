#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::simplify {

/// How far a collapse may change a vertex.
enum class VertexKind : std::uint8_t {
  kFree,    ///< May move in the plane and in height, and may vanish.
  kSlide,   ///< On a straight outline: may move along it and in height, and may vanish along it.
  kPinned,  ///< Corner of an outline: may change its height only.
  kLocked,  ///< Settled: nothing about it may change.
};

/// A vertex on the lattice: x eastward, y southward, z upward, in lattice steps.
struct LatticeVertex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend bool operator==(const LatticeVertex&, const LatticeVertex&) = default;
};

inline constexpr std::int32_t kNone = -1;

/// A triangle mesh in half-edges on arrays: half-edges 3t, 3t+1, 3t+2 are the sides of triangle t,
/// counter-clockwise seen from above. Outlines have no twin. Every vertex has one fan of triangles: where
/// two fans touch at a point, build() gives the second its own vertex. Removed triangles and vertices stay
/// in the arrays, marked. Not thread-safe; reuses its memory from build to build.
class HalfEdgeMesh {
 public:
  /// Takes over vertices and triangles (three indices each, counter-clockwise from above). Linear time.
  void build(std::vector<LatticeVertex> vertices, std::span<const std::array<std::int32_t, 3>> triangles);

  std::int32_t vertex_count() const { return static_cast<std::int32_t>(vertices.size()); }
  std::int32_t half_edge_count() const { return static_cast<std::int32_t>(origin_.size()); }
  const LatticeVertex& vertex(std::int32_t v) const { return vertices[index(v)]; }
  LatticeVertex& vertex(std::int32_t v) { return vertices[index(v)]; }
  bool alive(std::int32_t vertex) const { return outgoing_[index(vertex)] != kNone; }
  bool triangle_alive(std::int32_t half_edge) const { return origin_[index(half_edge)] != kNone; }

  static std::int32_t next(std::int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static std::int32_t previous(std::int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
  std::int32_t twin(std::int32_t h) const { return twin_[index(h)]; }
  std::int32_t origin(std::int32_t h) const { return origin_[index(h)]; }
  std::int32_t target(std::int32_t h) const { return origin(next(h)); }
  /// A half-edge that leaves the vertex; on an outline, the clockwise-most, which has no twin.
  std::int32_t outgoing(std::int32_t vertex) const { return outgoing_[index(vertex)]; }
  bool on_outline(std::int32_t vertex) const { return twin(outgoing(vertex)) == kNone; }
  /// The counter-clockwise-most half-edge that leaves a vertex on an outline: the outline goes on from the
  /// far end of previous(it).
  std::int32_t last_outgoing(std::int32_t vertex) const {
    std::int32_t h = outgoing(vertex);
    while (rotate(h) != kNone) h = rotate(h);
    return h;
  }
  /// The next half-edge around its origin, counter-clockwise; kNone past an outline.
  std::int32_t rotate(std::int32_t h) const { return twin(previous(h)); }

  /// Merges one end of `h` into the other, `kept`: both triangles at the edge vanish. The caller has checked
  /// that the result is a mesh (link condition) and does not fold.
  void collapse(std::int32_t h, std::int32_t kept);
  /// Joins the apexes of the two triangles at `h`, an inner edge, in place of its ends. The caller has checked that
  /// their quadrilateral is convex.
  void flip(std::int32_t h);

  std::vector<LatticeVertex> vertices;
  std::vector<VertexKind> kinds;

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  void match_twins();
  void split_fans();
  void close_gap(std::int32_t side);
  void reseat(std::int32_t vertex, std::span<const std::int32_t> candidates);

  std::vector<std::int32_t> origin_;
  std::vector<std::int32_t> twin_;
  std::vector<std::int32_t> outgoing_;
  std::vector<std::int32_t> chain_;  // scratch of match_twins
};

}  // namespace tintree::simplify
