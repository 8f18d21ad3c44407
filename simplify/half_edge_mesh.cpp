#include "simplify/half_edge_mesh.h"

#include <utility>

namespace tintree::simplify {

void HalfEdgeMesh::build(std::vector<LatticeVertex> points, std::span<const std::array<std::int32_t, 3>> triangles) {
  vertices = std::move(points);
  origin_.clear();
  for (const auto& t : triangles) origin_.insert(origin_.end(), t.begin(), t.end());
  match_twins();
  split_fans();
  kinds.assign(vertices.size(), VertexKind::kFree);
}

void HalfEdgeMesh::match_twins() {
  twin_.assign(origin_.size(), kNone);
  outgoing_.assign(vertices.size(), kNone);
  // outgoing_ heads a list, through chain_, of each vertex's half-edges that still lack a twin.
  chain_.assign(origin_.size(), kNone);
  for (std::int32_t h = 0; h < half_edge_count(); ++h) {
    const std::int32_t from = origin(h);
    const std::int32_t to = target(h);
    std::int32_t before = kNone;
    std::int32_t other = outgoing_[index(to)];
    while (other != kNone && target(other) != from) {
      before = other;
      other = chain_[index(other)];
    }
    if (other == kNone) {
      chain_[index(h)] = outgoing_[index(from)];
      outgoing_[index(from)] = h;
      continue;
    }
    (before == kNone ? outgoing_[index(to)] : chain_[index(before)]) = chain_[index(other)];
    twin_[index(h)] = other;
    twin_[index(other)] = h;
  }
}

/// Gives every vertex its outgoing half-edge, and every fan beyond a vertex's first a vertex of its own.
void HalfEdgeMesh::split_fans() {
  outgoing_.assign(vertices.size(), kNone);
  for (std::int32_t h = 0; h < half_edge_count(); ++h) {
    if (twin(h) != kNone) continue;
    std::int32_t v = origin(h);
    if (outgoing_[index(v)] != kNone) {
      vertices.push_back(vertices[index(v)]);
      outgoing_.push_back(kNone);
      v = vertex_count() - 1;
      for (std::int32_t o = h; o != kNone; o = rotate(o)) origin_[index(o)] = v;
    }
    outgoing_[index(v)] = h;
  }
  for (std::int32_t h = 0; h < half_edge_count(); ++h) {
    if (outgoing_[index(origin(h))] == kNone) outgoing_[index(origin(h))] = h;
  }
}

/// Removes the triangle of `side`, whose two other sides come to lie on each other.
void HalfEdgeMesh::close_gap(std::int32_t side) {
  const std::int32_t near = next(side);
  const std::int32_t far = previous(side);
  const std::int32_t a = twin(near);
  const std::int32_t b = twin(far);
  if (a != kNone) twin_[index(a)] = b;
  if (b != kNone) twin_[index(b)] = a;
  for (const std::int32_t h : {side, near, far}) origin_[index(h)] = kNone;
}

/// Points `vertex` at one of its surviving half-edges: wound back to the clockwise-most on an outline.
void HalfEdgeMesh::reseat(std::int32_t vertex, std::span<const std::int32_t> candidates) {
  std::int32_t start = kNone;
  for (const std::int32_t c : candidates) {
    if (c != kNone && origin(c) == vertex) start = c;
  }
  std::int32_t h = start;
  while (h != kNone && twin(h) != kNone) {
    h = next(twin(h));
    if (h == start) break;
  }
  outgoing_[index(vertex)] = h;
}

void HalfEdgeMesh::collapse(std::int32_t h, std::int32_t kept) {
  const std::int32_t gone = origin(h) == kept ? target(h) : origin(h);
  const std::int32_t other = twin(h);
  const std::int32_t apex = origin(previous(h));
  const std::int32_t other_apex = other == kNone ? kNone : origin(previous(other));

  // The half-edges that survive on both sides of the two gaps.
  std::array<std::int32_t, 8> around;
  around.fill(kNone);
  around[0] = twin(next(h));
  around[1] = twin(previous(h));
  if (other != kNone) {
    around[2] = twin(next(other));
    around[3] = twin(previous(other));
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (around[i] != kNone) around[i + 4] = next(around[i]);
  }

  const std::int32_t start = outgoing(gone);
  for (std::int32_t o = start; o != kNone;) {
    const std::int32_t following = rotate(o);
    origin_[index(o)] = kept;
    o = following == start ? kNone : following;
  }
  outgoing_[index(gone)] = kNone;
  close_gap(h);
  if (other != kNone) close_gap(other);
  reseat(kept, around);
  reseat(apex, around);
  if (other != kNone) reseat(other_apex, around);
}

void HalfEdgeMesh::flip(std::int32_t h) {
  const std::int32_t other = twin(h);
  const std::int32_t from_apex = previous(h);
  const std::int32_t from_other = previous(other);
  const std::int32_t a = origin(h);
  const std::int32_t b = origin(other);
  const std::int32_t apex = origin(from_apex);
  const std::int32_t other_apex = origin(from_other);
  // Each of the two moves to the outer side that the other triangle gives up; what had its place becomes the new edge.
  const auto move = [this](std::int32_t moved, std::int32_t outer) {
    origin_[index(moved)] = origin(outer);
    twin_[index(moved)] = twin(outer);
    if (twin(outer) != kNone) twin_[index(twin(outer))] = moved;
  };
  move(h, from_other);
  move(other, from_apex);
  twin_[index(from_apex)] = from_other;
  twin_[index(from_other)] = from_apex;
  const auto leave_by = [this](std::int32_t vertex, std::int32_t before, std::int32_t after) {
    if (outgoing(vertex) == before) outgoing_[index(vertex)] = after;
  };
  leave_by(a, h, next(other));
  leave_by(b, other, next(h));
  leave_by(other_apex, from_other, h);
  leave_by(apex, from_apex, other);
}

}  // namespace tintree::simplify
