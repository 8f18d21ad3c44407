#include "codec/tin_source.h"

#include <algorithm>
#include <span>

namespace tintree::codec {

std::optional<TinSource> TinSource::of(const TileMesh& mesh, std::int32_t most) {
  TinSource source;
  source.mesh_ = &mesh;
  if (mesh.triangles.empty() || mesh.triangles.size() > kMaxTileTriangles) return std::nullopt;
  for (const GridVertex& v : mesh.vertices) {
    if (v.x < 0 || v.y < 0 || v.x > most || v.y > most || v.z < 0 || v.z > kMaxHeightAddress) return std::nullopt;
    source.width_ = std::max(source.width_, v.x);
    source.height_ = std::max(source.height_, v.y);
  }
  for (const Triangle& t : mesh.triangles) {
    if (std::ranges::any_of(t, [&](std::uint32_t i) { return i >= mesh.vertices.size(); })) return std::nullopt;
    if (doubled_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]) <= 0) return std::nullopt;
  }
  if (!source.find_twins() || !source.whole_fans()) return std::nullopt;
  return source;
}

bool TinSource::find_twins() {
  const auto count = static_cast<std::int32_t>(3 * mesh_->triangles.size());
  first_.assign(mesh_->vertices.size() + 1, 0);
  for (std::int32_t h = 0; h < count; ++h) ++first_[origin(h) + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  leaving_.resize(static_cast<std::size_t>(count));
  std::vector<std::uint32_t> free(first_.begin(), first_.end() - 1);
  for (std::int32_t h = 0; h < count; ++h) leaving_[free[origin(h)]++] = h;
  const auto from = [&](std::uint32_t v) {
    return std::span(leaving_).subspan(first_[v], first_[v + 1] - std::size_t{first_[v]});
  };
  twins_.assign(static_cast<std::size_t>(count), kNone);
  for (std::int32_t h = 0; h < count; ++h) {
    const std::uint32_t a = origin(h);
    const std::uint32_t b = origin(following(h));
    if (a == b || std::ranges::count_if(from(a), [&](auto other) { return origin(following(other)) == b; }) > 1)
      return false;
    for (const std::int32_t other : from(b)) {
      if (origin(following(other)) == a) twins_[static_cast<std::size_t>(h)] = other;
    }
  }
  return true;
}

/// Whether the triangles around each vertex are one fan, and there are some.
bool TinSource::whole_fans() const {
  for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
    const std::uint32_t degree = first_[v + 1] - first_[v];
    if (degree == 0) return false;
    std::int32_t start = leaving_[first_[v]];
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      if (twin(leaving_[i]) == kNone) start = leaving_[i];
    }
    std::uint32_t seen = 1;
    for (std::int32_t h = twin(following(following(start))); h != kNone && h != start && seen <= degree; ++seen)
      h = twin(following(following(h)));
    if (seen != degree) return false;
  }
  return true;
}

std::vector<std::int32_t> TinSource::rectangle() const {
  const auto outline_from = [&](std::uint32_t v) {
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      if (twin(leaving_[i]) == kNone) return leaving_[i];
    }
    return kNone;
  };
  const auto& points = mesh_->vertices;
  const auto corner = std::ranges::find_if(points, [](const GridVertex& p) { return p.x == 0 && p.y == 0; });
  std::vector<std::int32_t> sides;
  if (corner == points.end()) return sides;
  const auto start = static_cast<std::uint32_t>(corner - points.begin());
  for (std::uint32_t v = start; sides.empty() || v != start;) {
    const std::int32_t half = outline_from(v);
    if (half == kNone) return {};
    sides.push_back(half);
    const GridVertex& a = points[v];
    v = origin(following(half));
    const GridVertex& b = points[v];
    // Counter-clockwise: south along the west side, and so on.
    const bool along = a.x == b.x ? (a.x == 0 && b.y > a.y) || (a.x == width_ && b.y < a.y)
                                  : a.y == b.y && ((a.y == height_ && b.x > a.x) || (a.y == 0 && b.x < a.x));
    if (!along) return {};
  }
  return sides;
}

}  // namespace tintree::codec
