#include "render/picking.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

namespace tintree::render {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// t at which the ray enters the box, 0 when it begins inside, kNever when it misses.
double entry(const cache::Box& box, const Ray& ray) {
  double from = 0;
  double to = kNever;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const double low = box.min[axis] - ray.origin[i];
    const double high = box.max[axis] - ray.origin[i];
    if (ray.direction[i] == 0) {
      if (low > 0 || high < 0) return kNever;
      continue;
    }
    const double a = low / ray.direction[i];
    const double b = high / ray.direction[i];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  // A ray along a side of the box, or through a flat one, must not be lost to rounding.
  return from <= to + 1e-9 * std::abs(to) ? from : kNever;
}

/// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997); a ray through an edge meets both
/// of its triangles.
double meet(const Ray& ray, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  constexpr double kSlack = 1e-9;
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 p = glm::cross(ray.direction, ac);
  const double det = glm::dot(ab, p);
  if (det == 0) return kNever;
  const glm::dvec3 s = ray.origin - a;
  const double u = glm::dot(s, p) / det;
  if (!(u >= -kSlack && u <= 1 + kSlack)) return kNever;
  const glm::dvec3 q = glm::cross(s, ab);
  const double v = glm::dot(ray.direction, q) / det;
  if (!(v >= -kSlack && u + v <= 1 + kSlack)) return kNever;
  const double t = glm::dot(ac, q) / det;
  return t >= 0 ? t : kNever;
}

class Walk {
 public:
  Walk(Trees trees, std::uint32_t tree, const FindTile& find, const Ray& ray)
      : bounds_(*trees[tree]), tree_(tree), find_(find), ray_(ray) {}

  std::optional<GroundPoint> run() {
    if (bounds_.nodes().empty() || !visit(0)) return std::nullopt;
    return hit_;
  }

 private:
  struct Child {
    double entry;
    std::uint32_t node;
  };

  /// Looks for a hit under a node; false when a tile that it takes is not in memory.
  bool visit(std::uint32_t index) {
    if (visit_children(index)) return true;
    const cache::TileNode& node = bounds_.nodes()[index];
    const auto tile = find_({node.id, tree_});
    if (tile == nullptr) return false;
    const auto t = first_hit(*tile, ray_);
    hit_.reset();
    if (t) hit_ = GroundPoint{ray_.origin + *t * ray_.direction, *t, tree_, index};
    return true;
  }

  bool visit_children(std::uint32_t index) {
    const cache::TileNode& node = bounds_.nodes()[index];
    const auto count = static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(node.child_mask)));
    if (count == 0) return false;
    std::array<Child, 4> children{};
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t child = node.first_child + i;
      children[i] = {entry(bounds_.box(bounds_.nodes()[child]), ray_), child};
    }
    std::ranges::sort(children.begin(), children.begin() + count, {}, &Child::entry);
    std::optional<GroundPoint> nearest;
    for (std::uint32_t i = 0; i < count && children[i].entry < (nearest ? nearest->t : kNever); ++i) {
      if (!visit(children[i].node)) return false;
      if (hit_ && (!nearest || hit_->t < nearest->t)) nearest = hit_;
    }
    hit_ = nearest;
    return true;
  }

  const cache::TileBounds& bounds_;
  const std::uint32_t tree_;
  const FindTile& find_;
  const Ray& ray_;
  std::optional<GroundPoint> hit_;
};

/// Of the triangles with corners place(0), place(1), ...
template <typename Place>
double first_of(const Ray& ray, std::size_t corners, const Place& place) {
  double first = kNever;
  for (std::size_t i = 0; i < corners; i += 3) first = std::min(first, meet(ray, place(i), place(i + 1), place(i + 2)));
  return first;
}

double first_of(const Ray& ray, const cache::StripShape& shape) {
  const std::vector<std::uint32_t> words = shape.words();
  const codec::StripWords format(shape.strip());
  return first_of(ray, words.size(), [&](std::size_t i) {
    const std::uint32_t w = words[i];
    return glm::dvec3(format.x(w), format.y(w), format.height(w) << shape.strip().z_shift);
  });
}

double first_of(const Ray& ray, const cache::DrawableTile& tile) {
  const std::size_t corners = 3 * std::size_t{tile.surface_triangles};
  if (const cache::QuantizedShape* shape = tile.native.scalar.get()) {
    return first_of(ray, corners, [&](std::size_t i) {
      const codec::GridVertex v = shape->vertex(shape->words[tile.index(i)]);
      return glm::dvec3(v.x, v.y, v.z);
    });
  }
  return first_of(ray, corners, [&](std::size_t i) {
    const cache::DrawVertex& v = tile.vertices[tile.index(i)];
    return glm::dvec3(v.x(), v.y(), v.z());
  });
}

}  // namespace

std::optional<double> first_hit(const cache::DrawableTile& tile, const Ray& ray) {
  // On the tile's own grid: an affine change of the frame leaves t as it is.
  const auto matrix = tile.frame.matrix({ray.origin.x, ray.origin.y, ray.origin.z});
  const glm::dmat4 to_grid = glm::inverse(glm::make_mat4(matrix.data()));
  const Ray local{glm::dvec3(to_grid[3]), glm::dvec3(to_grid * glm::dvec4(ray.direction, 0))};
  const double first = tile.native.strip ? first_of(local, *tile.native.strip) : first_of(local, tile);
  if (first == kNever) return std::nullopt;
  return first;
}

std::optional<GroundPoint> pick(Trees trees, const FindTile& find, const Ray& ray) {
  std::optional<GroundPoint> nearest;
  for (std::uint32_t tree = 0; tree < trees.size(); ++tree) {
    const auto hit = Walk(trees, tree, find, ray).run();
    if (hit && (!nearest || hit->t < nearest->t)) nearest = hit;
  }
  return nearest;
}

std::optional<GroundPoint> ground_at(Trees trees, const FindTile& find, double x_m, double y_m) {
  double above = 0;
  for (const cache::TileBounds* tree : trees) {
    if (!tree->nodes().empty()) above = std::max(above, tree->box(tree->nodes().front()).max[2] + 1);
  }
  return pick(trees, find, {{x_m, y_m, above}, {0, 0, -1}});
}

}  // namespace tintree::render
