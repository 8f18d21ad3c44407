#include "codec/strip_follower.h"

#include <algorithm>

#include "codec/split_fans.h"

namespace tintree::codec {

StripFollower::StripFollower(const StripHead& head, const StripHeader& first)
    : head_(head), span_(1 << head.levels), numbers_(span_), edge_(first.edge) {
  places_.reserve(head.triangles + std::size_t{2});
  corners_.reserve(head.triangles);
  inside_ = edge_.size <= head.levels && add(first.x, first.y) && add_other_end(places_[0], 1);
}

bool StripFollower::add(std::int32_t x, std::int32_t y) {
  if (x < 0 || y < 0 || x > span_ || y > span_) return false;
  std::int32_t vertex = numbers_.get(x, y);
  if (vertex == kNoPoint) numbers_.set(x, y, vertex = vertices_++);
  places_.push_back({x, y, vertex});
  return true;
}

/// The vertex at the edge's other end.
bool StripFollower::add_other_end(const Place& from, int sign) {
  const auto d = static_cast<std::size_t>(edge_.direction);
  const std::int32_t length = sign * (1 << edge_.size);
  return add(from.x + kStripX[d] * length, from.y + kStripY[d] * length);
}

StripHeader StripFollower::header(bool left) const {
  StripHeader header{places_[entering_[0]].x, places_[entering_[0]].y, edge_, 2, true, left};
  const auto entry = static_cast<std::uint32_t>(corners_.size()) + 2;
  header.back_is_v1 = entry - entering_[0] != 1;
  header.back = entry - entering_[header.back_is_v1 ? 0 : 1];
  return header;
}

bool StripFollower::step(StripType type, bool left) {
  if (!inside_) return false;
  edge_ = edge_.next(type, left);
  const auto entry = static_cast<std::uint32_t>(places_.size());
  if (edge_.size < 0 || edge_.size > head_.levels || !add_other_end(places_[entering_[left ? 0 : 1]], left ? 1 : -1))
    return false;
  corners_.push_back({entering_[0], entering_[1], entry});
  entering_[left ? 1 : 0] = entry;
  return true;
}

Expected<TileMesh> StripFollower::mesh(std::span<const std::uint32_t> heights) const {
  const auto refuse = [] { return fail(ErrorCode::kBadData, "the payload's strip is damaged"); };
  constexpr std::uint32_t kNew = UINT32_MAX;
  TileMesh mesh;
  mesh.xy_shift = head_.xy_shift;
  mesh.z_offset = head_.z_offset;
  mesh.triangles.reserve(corners_.size());
  std::vector<std::uint32_t> index(corners_.size() + 2, kNew);
  const std::int32_t odd = head_.fine != 0 ? 1 : 0;
  for (const auto& corners : corners_) {
    if (std::ranges::any_of(corners, [&](std::uint32_t e) { return heights[e] == head_.missing(); })) continue;
    Triangle& t = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Place& p = places_[corners[k]];
      if (((p.x | p.y) & odd) != 0) return refuse();
      const GridVertex at{p.x >> head_.fine, p.y >> head_.fine,
                          static_cast<std::int32_t>(heights[corners[k]] << head_.z_shift)};
      std::uint32_t& i = index[vertex(corners[k])];
      if (i == kNew) {
        i = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(at);
      } else if (mesh.vertices[i].z != at.z) {
        return refuse();
      }
      t[k] = i;
    }
  }
  if (head_.holes) split_fans(mesh);
  return mesh;
}

}  // namespace tintree::codec
