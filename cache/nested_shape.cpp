#include "cache/nested_shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "cache/drawable_tile.h"
#include "cache/nested_borders.h"
#include "cache/nested_own_levels.h"
#include "cache/nested_shape_packing.h"
#include "codec/nested_points.h"
#include "codec/sparse_grid.h"
#include "codec/split_hierarchy.h"

namespace tintree::cache {
namespace {

constexpr std::size_t kFinest = NestedShape::kLevels - 1;
/// Points by their places: kNone, a vertex's number, or below kNone the level of a gap.
constexpr std::int32_t kNone = codec::kNoPoint;
using Places = codec::PointNumbers;
std::int32_t gap_of_level(int level) { return kNone - 1 - level; }
int level_of_gap(std::int32_t found) { return kNone - 1 - found; }

using Heights = NestedShapePoint::Heights;
using Point = NestedShapePoint;

template <typename Numbers>
Numbers mean(const Numbers& a, const Numbers& b) {
  Numbers out = a;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (a[i] + b[i]) / 2;
  return out;
}

template <typename From>
float unpacked(From v) {
  return static_cast<float>(v) / static_cast<float>(std::numeric_limits<From>::max());
}

class ShapeMaker {
 public:
  ShapeMaker(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
             const DrawableTile& drawable, double error_m, std::uint16_t joined_sides, const NestedShape* parent)
      : mesh_(mesh),
        drawable_(drawable),
        parent_(parent),
        id_(id),
        frame_(layout, id, mesh),
        shift_(parent == nullptr ? mesh.xy_shift : std::min(mesh.xy_shift, parent->frame.xy_shift)),
        side_(static_cast<std::int32_t>(std::ldexp(static_cast<double>(layout.cells_across(id.level)), -shift_))),
        bound_steps_(layout.bound_m(id.level) / frame_.z_step_m),
        error_steps_(error_m / frame_.z_step_m),
        own_(side_),
        inherited_(side_),
        made_(side_),
        outline_(tile_outline(layout, id, shift_, joined_sides)) {}

  NestedShape make() {
    note_own();
    if (parent_ != nullptr) note_parents();
    add_base();
    const auto split = [this](std::int32_t a, std::int32_t b, std::int32_t) { return middle(a, b); };
    for (const auto& [a, b] : codec::kSquareSides)
      codec::bisect(a, b, codec::NestedPoints::kBasePoints - 1, split, [](auto...) {});
    if (parent_ == nullptr) choose_own_levels(points_, bound_steps_, error_steps_);
    codec::GridFrame frame = frame_;
    frame.xy_shift = shift_;
    NestedShape shape = pack_nested_shape(std::move(points_), frame, side_, bound_steps_);
    shape.skirt_sides = outline_.sides;
    add_nested_borders(shape, outline_);
    return shape;
  }

 private:
  std::int32_t quadrant_x() const { return static_cast<std::int32_t>(id_.x & 1U); }
  std::int32_t quadrant_y() const { return static_cast<std::int32_t>(id_.y & 1U); }
  Point& point(std::int32_t i) { return points_[static_cast<std::size_t>(i)]; }

  void note_own() {
    const int digits = mesh_.xy_shift - shift_;
    for (std::size_t v = 0; v < mesh_.nested_levels.size(); ++v)
      own_.set(mesh_.vertices[v].x << digits, mesh_.vertices[v].y << digits, static_cast<std::int32_t>(v));
    for (const codec::NestedGap& g : mesh_.nested_gaps)
      own_.set(g.x << digits, g.y << digits, gap_of_level(parent_ == nullptr ? g.level : kFinest));
  }

  /// The parent's points in the tile's square, and the parent's corners.
  void note_parents() {
    const int digits = parent_->frame.xy_shift - shift_;
    const auto note = [&](std::int32_t x, std::int32_t y, std::int32_t number) {
      const std::int32_t here_x = (x << digits) - quadrant_x() * side_;
      const std::int32_t here_y = (y << digits) - quadrant_y() * side_;
      if (std::min(here_x, here_y) >= 0 && std::max(here_x, here_y) <= side_) inherited_.set(here_x, here_y, number);
      const std::int32_t far = parent_->side;
      if ((x == 0 || x == far) && (y == 0 || y == far))
        parents_corners_[(x != 0 ? 1U : 0U) | (y != 0 ? 2U : 0U)] = number;
    };
    for (std::size_t v = 0; v < parent_->vertices.size(); ++v)
      note(parent_->vertices[v].x(), parent_->vertices[v].y(), static_cast<std::int32_t>(v));
    for (const codec::NestedGap& g : parent_->gaps) note(g.x, g.y, gap_of_level(std::max(g.level - 1, 0)));
  }

  /// The heights and normals of a vertex of the parent, as levels of this tile.
  void inherit(Point& p, std::size_t v) const {
    const NestedVertex& from = parent_->vertices[v];
    const double step = parent_->frame.z_step_m / frame_.z_step_m;
    const double z =
        static_cast<double>(parent_->frame.z_offset + from.z()) * step - static_cast<double>(frame_.z_offset);
    for (std::size_t k = 0; k < kFinest; ++k)
      p.z[k] = z + (k + 1 < kFinest ? from.rises[k + 1] * static_cast<double>(parent_->units[k + 1]) * step : 0);
    p.normals[1] = {unpacked(from.normal[0]), unpacked(from.normal[1])};
    p.normals[2] = {unpacked(from.coarse_normals[0]), unpacked(from.coarse_normals[1])};
  }

  int inherited_level(std::int32_t vertex) const {
    const auto& ends = parent_->fans.level_vertices;
    const auto at = std::ranges::upper_bound(ends, static_cast<std::uint32_t>(vertex));
    return std::max(static_cast<int>(at - ends.begin()) - 1, 0);
  }

  /// Sets what the coarser levels' meshes say of a point whose `z` and normal on the finest are there already. `ends`:
  /// of the side that it splits, between which those are plane that do not have it.
  void set_coarse(Point& p, std::int32_t inherited, const Point* a, const Point* b) const {
    const Heights own = p.z;
    if (inherited >= 0) return inherit(p, static_cast<std::size_t>(inherited));
    p.z.fill(own[kFinest]);
    p.normals[1] = p.normals[2] = p.normals[0];
    if (a == nullptr || a->gap || b->gap) return;
    p.z = mean(a->z, b->z);
    p.z[kFinest] = own[kFinest];
    for (std::size_t k = 1; k < 3 && parent_ != nullptr; ++k) p.normals[k] = mean(a->normals[k], b->normals[k]);
  }

  void set_own(Point& p, std::int32_t vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    p.z[kFinest] = mesh_.vertices[v].z;
    p.normals[0] = {unpacked(drawable_.vertices[v].normal_x), unpacked(drawable_.vertices[v].normal_y)};
  }

  std::int32_t add(const Point& p) {
    const auto number = static_cast<std::int32_t>(points_.size());
    points_.push_back(p);
    made_.set(p.x, p.y, number);
    return number;
  }

  /// The five points that are always there. A corner of the tile that is none of the parent's, the middle of a side of
  /// the parent or of a half diagonal, lies between two that are.
  void add_base() {
    const codec::NestedPoints places(std::countr_zero(static_cast<std::uint32_t>(side_)));
    const auto corner = static_cast<std::size_t>(quadrant_x() | quadrant_y() << 1);
    std::array<Point, 4> parents{};
    for (std::size_t k = 0; k < 4 && parent_ != nullptr; ++k) {
      parents[k].gap = parents_corners_[k] < 0;
      if (!parents[k].gap) inherit(parents[k], static_cast<std::size_t>(parents_corners_[k]));
    }
    for (std::size_t i = 0; i < codec::NestedPoints::kBasePoints; ++i) {
      const auto [x, y] = places.base_place(static_cast<std::int32_t>(i));
      Point p{x, y, 0, false, {}, {}};
      const std::int32_t own = own_.get(x, y);
      p.gap = own < 0;
      if (!p.gap) {
        set_own(p, own);
        if (parent_ == nullptr) {
          set_coarse(p, kNone, nullptr, nullptr);
        } else if (i == codec::NestedPoints::kBasePoints - 1) {
          set_coarse(p, inherited_.get(x, y), &parents[corner], &points_[corner ^ 3U]);
        } else {
          set_coarse(p, inherited_.get(x, y), &parents[corner], &parents[i]);
        }
      }
      add(p);
    }
  }

  std::int32_t find_or_add(std::int32_t x, std::int32_t y, std::int32_t a, std::int32_t b) {
    if (const std::int32_t known = made_.get(x, y); known != kNone) return known;
    const std::int32_t own = own_.get(x, y);
    const std::int32_t inherited = inherited_.get(x, y);
    if (own == kNone && inherited == kNone) return kNone;
    Point p{x, y, 0, false, {}, {}};
    // A triangle that is not there keeps a gap in all its parts.
    p.gap = own == kNone ? point(a).gap || point(b).gap : own < 0;
    p.level = static_cast<int>(kFinest);
    if (inherited != kNone) p.level = inherited < 0 ? level_of_gap(inherited) : inherited_level(inherited);
    if (parent_ == nullptr) p.level = own < 0 ? level_of_gap(own) : mesh_.nested_levels[static_cast<std::size_t>(own)];
    if (p.gap) return add(p);
    if (own >= 0) {
      set_own(p, own);
    } else {
      p.z[kFinest] = (point(a).z[kFinest] + point(b).z[kFinest]) / 2;
      p.normals[0] = mean(point(a).normals[0], point(b).normals[0]);
    }
    set_coarse(p, inherited, &point(a), &point(b));
    // Of the tile's own levels, those from the point's on have it.
    if (parent_ == nullptr) std::fill(p.z.begin() + p.level, p.z.end(), p.z[kFinest]);
    return add(p);
  }

  std::optional<std::int32_t> middle(std::int32_t a, std::int32_t b) {
    const std::int32_t x = point(a).x + point(b).x;
    const std::int32_t y = point(a).y + point(b).y;
    const std::int32_t found = ((x | y) & 1) != 0 ? kNone : find_or_add(x / 2, y / 2, a, b);
    return found == kNone ? std::nullopt : std::optional(found);
  }

  const codec::TileMesh& mesh_;
  const DrawableTile& drawable_;
  const NestedShape* parent_;
  codec::TileId id_;
  codec::GridFrame frame_;  // of the stored mesh
  int shift_;               // of the shape's addresses
  std::int32_t side_;
  double bound_steps_;
  double error_steps_;
  Places own_;        // vertices of the mesh
  Places inherited_;  // vertices of the parent
  Places made_;       // points
  TileOutline outline_;
  std::array<std::int32_t, 4> parents_corners_{kNone, kNone, kNone, kNone};
  std::vector<Point> points_;
};

}  // namespace

std::size_t NestedShape::bytes() const {
  std::size_t out = sizeof *this + vertices.size() * sizeof(NestedVertex) + gaps.size() * sizeof(codec::NestedGap) +
                    fans.vertex_points.size() * sizeof(std::int32_t);
  for (const auto& level : fans.fans) out += level.size() * sizeof(std::uint32_t);
  for (const auto& border : borders) out += border.size() * sizeof(BorderVertex);
  return out;
}

bool can_have_nested_shape(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh) {
  // Half samples are the finest that the outlines of neighbours are compared by.
  if (mesh.nested_levels.empty() || mesh.xy_shift < -1) return false;
  const double side = std::ldexp(static_cast<double>(layout.cells_across(id.level)), -mesh.xy_shift);
  if (side < 2 || side > 1 << codec::NestedPoints::kMostSideBits) return false;
  int corners_and_centre = 0;
  const auto inside = [&](const auto& p) {
    const auto in_line = [side](double v) { return v == 0 || v == side; };
    corners_and_centre += (in_line(p.x) && in_line(p.y)) || (2.0 * p.x == side && 2.0 * p.y == side) ? 1 : 0;
    return p.x >= 0 && p.y >= 0 && p.x <= side && p.y <= side;
  };
  const std::span vertices(mesh.vertices.begin(), std::min(mesh.nested_levels.size(), mesh.vertices.size()));
  return std::ranges::all_of(vertices, inside) && std::ranges::all_of(mesh.nested_gaps, inside) &&
         corners_and_centre == codec::NestedPoints::kBasePoints;
}

NestedShape make_nested_shape(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh,
                              const DrawableTile& drawable, double error_m, std::uint16_t joined_sides,
                              const NestedShape* parent) {
  return ShapeMaker(layout, id, mesh, drawable, error_m, joined_sides, parent).make();
}

}  // namespace tintree::cache
