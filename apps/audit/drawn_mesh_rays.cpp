#include "apps/audit/drawn_mesh_rays.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include <glm/geometric.hpp>

#include "codec/grid_frame.h"

namespace tintree::audit {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double length_2 = glm::dot(ab, ab);
  const double t = length_2 > 0 ? std::clamp(glm::dot(p - a, ab) / length_2, 0.0, 1.0) : 0;
  return glm::distance(p, a + t * ab);
}

double distance_to_triangle(const glm::dvec3& p, const std::array<glm::dvec3, 3>& c) {
  const glm::dvec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
  double to_edges = kNone;
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3& a = c[k];
    const glm::dvec3& b = c[(k + 1) % 3];
    to_edges = std::min(to_edges, distance_to_segment(p, a, b));
    inside = inside && glm::dot(glm::cross(b - a, p - a), normal) >= 0;
  }
  return inside ? std::abs(glm::dot(p - c[0], glm::normalize(normal))) : to_edges;
}

/// Farther from a box round the triangle than this, a point need not be compared with it.
bool within(const glm::dvec3& p, const std::array<glm::dvec3, 3>& c, double distance_m) {
  const glm::dvec3 low = glm::min(c[0], glm::min(c[1], c[2]));
  const glm::dvec3 high = glm::max(c[0], glm::max(c[1], c[2]));
  const glm::dvec3 beyond = glm::max(glm::dvec3(0), glm::max(low - p, p - high));
  return glm::dot(beyond, beyond) <= distance_m * distance_m;
}

}  // namespace

Expected<DrawnMeshRays> DrawnMeshRays::read(const cache::TileStore& store, const render::LodCut& cut,
                                            const glm::dvec3& eye) {
  DrawnMeshRays out;
  out.eye_ = eye;
  for (const render::DrawTile& draw : cut.draws) {
    const codec::TileId& id = store.bounds().nodes()[draw.node].id;
    const auto mesh = store.read_mesh(id);
    if (!mesh) return tl::unexpected(mesh.error());
    const codec::GridFrame frame(store.manifest().layout, id, *mesh);
    const auto first = static_cast<std::uint32_t>(out.vertices_.size());
    for (const codec::GridVertex& v : mesh->vertices) {
      const auto [x, y, z] = frame.world(v);
      out.vertices_.push_back(glm::dvec3(x, y, z) - eye);
    }
    for (const codec::Triangle& t : mesh->triangles) {
      out.triangles_.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  return out;
}

double DrawnMeshRays::cast(const glm::dvec3& ray) const {
  double nearest = kNone;
  for (const codec::Triangle& t : triangles_) {
    const glm::dvec3& a = vertices_[t[0]];
    const glm::dvec3& b = vertices_[t[1]];
    const glm::dvec3& c = vertices_[t[2]];
    // On which side of each edge's plane through the eye; two triangles at an edge find opposite numbers.
    const double of_a = glm::dot(ray, glm::cross(b, c));
    const double of_b = glm::dot(ray, glm::cross(c, a));
    const double of_c = glm::dot(ray, glm::cross(a, b));
    const auto [least, most] = std::minmax({of_a, of_b, of_c});
    const double sum = of_a + of_b + of_c;
    if ((least < 0 && most > 0) || sum == 0) continue;
    // A mean of the corners: never outside the triangle, however thin that looks.
    const glm::dvec3 hit = (of_a * a + of_b * b + of_c * c) / sum;
    const double depth = glm::dot(hit, ray) / glm::dot(ray, ray);
    if (depth > 0) nearest = std::min(nearest, depth);
  }
  return nearest;
}

double DrawnMeshRays::distance_m(const glm::dvec3& point) const {
  const glm::dvec3 p = point - eye_;
  double nearest = kNone;
  for (const codec::Triangle& t : triangles_) {
    const std::array<glm::dvec3, 3> corners{vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    if (within(p, corners, nearest)) nearest = std::min(nearest, distance_to_triangle(p, corners));
  }
  return nearest;
}

}  // namespace tintree::audit
