#include <algorithm>
#include <cstddef>
#include <utility>

#include "codec/scalar_grid.h"

namespace tintree::codec {
namespace {

constexpr std::uint32_t kNowhere = 0xffffffff;

Triangle rotated(const Triangle& t) {
  if (t[0] < t[1] && t[0] < t[2]) return t;
  return t[1] < t[2] ? Triangle{t[1], t[2], t[0]} : Triangle{t[2], t[0], t[1]};
}

/// Tries whether a mesh is a grid of a given shape.
class GridMatch {
 public:
  GridMatch(const TileMesh& mesh, ScalarGrid grid) : mesh_(&mesh), border_count_(grid.border_count()) {
    tile_.grid = std::move(grid);
    tile_.xy_shift = mesh.xy_shift;
    tile_.z_offset = mesh.z_offset;
    tile_.z.assign(tile_.grid.vertex_count(), 0);
    number_side_starts();
  }

  std::optional<ScalarTile> match() {
    if (!tile_.grid.is_sound() || !place_vertices() || !same_triangles()) return std::nullopt;
    if (std::ranges::find(tile_.missing, true) == tile_.missing.end()) tile_.missing.clear();
    return std::move(tile_);
  }

 private:
  void number_side_starts() {
    const auto& s = tile_.grid.sides;
    east_ = s[ScalarGrid::kNorth].size() - 1;  // its vertex 0 is the north side's last
    south_ = east_ + s[ScalarGrid::kEast].size();
    west_ = south_ + s[ScalarGrid::kSouth].size() - 2;  // its vertex 1 comes first
  }

  std::uint32_t on_side(int side, std::int32_t at, std::size_t first) const {
    const std::vector<std::int32_t>& places = tile_.grid.sides[static_cast<std::size_t>(side)];
    const auto found = std::ranges::lower_bound(places, at);
    if (found == places.end() || *found != at) return kNowhere;
    return static_cast<std::uint32_t>(first + static_cast<std::size_t>(found - places.begin()));
  }

  std::uint32_t number_of(const GridVertex& v) const {
    const ScalarGrid& g = tile_.grid;
    if (v.y == 0) return on_side(ScalarGrid::kNorth, v.x, 0);
    if (v.x == g.width) return on_side(ScalarGrid::kEast, v.y, east_);
    if (v.y == g.height) return on_side(ScalarGrid::kSouth, v.x, south_);
    if (v.x == 0) return on_side(ScalarGrid::kWest, v.y, west_);
    const std::int64_t column = v.x / g.stride;
    const std::int64_t row = v.y / g.stride;
    if (column * g.stride != v.x || row * g.stride != v.y || column > g.columns() || row > g.rows()) return kNowhere;
    return static_cast<std::uint32_t>(border_count_ + static_cast<std::size_t>((row - 1) * g.columns() + column - 1));
  }

  bool place_vertices() {
    tile_.missing.assign(tile_.z.size(), true);
    numbers_.clear();
    for (const GridVertex& v : mesh_->vertices) {
      const std::uint32_t i = number_of(v);
      // Fans that meet in a place have a vertex each there.
      if (i == kNowhere || (!tile_.missing[i] && tile_.z[i] != v.z)) return false;
      tile_.missing[i] = false;
      tile_.z[i] = v.z;
      numbers_.push_back(i);
    }
    return true;
  }

  bool same_triangles() const {
    std::vector<Triangle> wanted = tile_.grid.triangles();
    std::erase_if(wanted, [this](const Triangle& t) {
      return tile_.missing[t[0]] || tile_.missing[t[1]] || tile_.missing[t[2]];
    });
    if (wanted.size() != mesh_->triangles.size()) return false;
    std::vector<Triangle> found;
    found.reserve(wanted.size());
    for (const Triangle& t : mesh_->triangles) {
      found.push_back(rotated({numbers_[t[0]], numbers_[t[1]], numbers_[t[2]]}));
    }
    for (Triangle& t : wanted) t = rotated(t);
    if (found == wanted) return true;
    std::ranges::sort(found);
    std::ranges::sort(wanted);
    return found == wanted;
  }

  const TileMesh* mesh_;
  std::size_t border_count_;
  ScalarTile tile_;
  std::size_t east_ = 0;
  std::size_t south_ = 0;
  std::size_t west_ = 0;
  std::vector<std::uint32_t> numbers_;  // of the mesh's vertices
};

/// The line of a side: y = `at` or x = `at`.
struct SideLine {
  bool horizontal;
  std::int32_t at;

  bool holds(const GridVertex& v) const { return (horizontal ? v.y : v.x) == at; }
  std::int32_t along(const GridVertex& v) const { return horizontal ? v.x : v.y; }
};

std::array<SideLine, 4> side_lines(std::int32_t width, std::int32_t height) {
  return {SideLine{true, 0}, SideLine{false, width}, SideLine{true, height}, SideLine{false, 0}};
}

/// Every vertex is there: on the sides, and in a grid whose stride the first of them tells.
std::optional<ScalarTile> find_whole(const TileMesh& mesh, std::int32_t width, std::int32_t height) {
  ScalarGrid grid{.width = width, .height = height, .stride = 1, .sides = {}};
  const auto lines = side_lines(width, height);
  std::int32_t stride = 0;
  for (const GridVertex& v : mesh.vertices) {
    bool on_side = false;
    for (std::size_t side = 0; side < 4; ++side) {
      if (!lines[side].holds(v)) continue;
      grid.sides[side].push_back(lines[side].along(v));
      on_side = true;
    }
    if (!on_side && (stride == 0 || v.x < stride)) stride = v.x;
  }
  if (stride > 0) grid.stride = stride;
  for (std::size_t side = 0; side < 4; ++side) {
    std::vector<std::int32_t>& places = grid.sides[side];
    std::ranges::sort(places);
    if (places.size() < 2 || places.front() != 0 || places.back() != grid.length(static_cast<int>(side)) ||
        std::ranges::adjacent_find(places) != places.end()) {
      return std::nullopt;
    }
  }
  if (grid.vertex_count() != mesh.vertices.size()) return std::nullopt;
  auto tile = GridMatch(mesh, std::move(grid)).match();
  // As many may be missing as there are twice, where fans meet.
  return tile && tile->missing.empty() ? std::move(tile) : std::nullopt;
}

/// Vertices are missing: the stride is 1, and a side has its vertices a step apart but where it has a longer edge.
std::optional<ScalarTile> find_holed(const TileMesh& mesh, std::int32_t width, std::int32_t height) {
  if ((std::int64_t{width} + 1) * (std::int64_t{height} + 1) > 2 * kMaxGridVertices) return std::nullopt;
  ScalarGrid grid{.width = width, .height = height, .stride = 1, .sides = {}};
  const auto lines = side_lines(width, height);
  for (std::size_t side = 0; side < 4; ++side) {
    std::vector<bool> vertex(static_cast<std::size_t>(grid.length(static_cast<int>(side))) + 1, true);
    for (const Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const GridVertex& a = mesh.vertices[t[k]];
        const GridVertex& b = mesh.vertices[t[(k + 1) % 3]];
        if (!lines[side].holds(a) || !lines[side].holds(b)) continue;
        const auto [from, to] = std::minmax({lines[side].along(a), lines[side].along(b)});
        for (std::int32_t at = from + 1; at < to; ++at) vertex[static_cast<std::size_t>(at)] = false;
      }
    }
    for (std::size_t at = 0; at < vertex.size(); ++at) {
      if (vertex[at]) grid.sides[side].push_back(static_cast<std::int32_t>(at));
    }
  }
  return GridMatch(mesh, std::move(grid)).match();
}

}  // namespace

std::optional<ScalarTile> find_scalar_tile(const TileMesh& mesh) {
  std::int32_t width = 0;
  std::int32_t height = 0;
  for (const GridVertex& v : mesh.vertices) {
    width = std::max(width, v.x);
    height = std::max(height, v.y);
  }
  if (mesh.triangles.empty() || width == 0 || height == 0) return std::nullopt;
  if (auto whole = find_whole(mesh, width, height)) return whole;
  // Vertices may be missing on the east and south side too, so that they seem to lie further in.
  for (const std::int32_t below : {0, 1}) {
    for (const std::int32_t beside : {0, 1}) {
      if (auto holed = find_holed(mesh, width + beside, height + below)) return holed;
    }
  }
  return std::nullopt;
}

}  // namespace tintree::codec
