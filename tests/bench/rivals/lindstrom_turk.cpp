#include <cmath>
#include <optional>
#include <utility>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "tests/bench/rivals/cpu_clock.h"
#include "tests/bench/rivals/mesh_error.h"
#include "tests/bench/rivals/simplifiers.h"

namespace tintree::bench {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

/// The error is measured each time that this share of the edges is left.
constexpr double kStep = 0.95;

Mesh to_cgal(const TriangleMesh& mesh) {
  Mesh out;
  for (const auto& [x, y, z] : mesh.vertices) out.add_vertex({x, y, z});
  for (const auto& t : mesh.triangles) {
    out.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
  }
  return out;
}

double rounded_to(double value, double step) { return std::round(value / step) * step; }

TriangleMesh delivered(const Mesh& mesh, const HeightGrid& grid, double error_m) {
  TriangleMesh out;
  out.vertices.resize(mesh.num_vertices());  // removed ones too, until compacted
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    out.vertices[v] = {rounded_to(p.x(), grid.dx_m / 8), rounded_to(p.y(), grid.dy_m / 8),
                       rounded_to(p.z(), error_m / 16)};
  }
  for (const auto face : mesh.faces()) {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) triangle[k++] = v;
    out.triangles.push_back(triangle);
  }
  return compacted(out);
}

/// Watches the collapse, keeps the last mesh within the error and stops at the first one beyond it.
struct Watch {
  const HeightGrid& grid;
  double error_m;
  TriangleMesh kept;
  CpuClock clock{};
  std::size_t next_count = 0;
  double seconds = 0;

  bool keep(const Mesh& mesh) {
    bool within = false;
    const double now = clock.seconds();
    clock.pause_for([&] {
      TriangleMesh candidate = delivered(mesh, grid, error_m);
      const MeshError error = measure(grid, candidate);
      within = error.samples_max_m <= error_m;
      if (within) {
        kept = std::move(candidate);
        seconds = now;
      }
    });
    return within;
  }
};

struct Stop {
  Watch* watch;

  template <class Cost, class Profile>
  bool operator()(const Cost&, const Profile& profile, std::size_t initial, std::size_t current) const {
    if (watch->next_count == 0) watch->next_count = initial;
    if (current > watch->next_count) return false;
    watch->next_count = static_cast<std::size_t>(kStep * static_cast<double>(current));
    return !watch->keep(profile.surface_mesh());
  }
};

}  // namespace

Simplified lindstrom_turk(const HeightGrid& grid, double error_m) {
  const TriangleMesh full = full_mesh(grid);
  Mesh mesh = to_cgal(full);
  Watch watch{grid, error_m, full};
  sms::edge_collapse(
      mesh, Stop{&watch},
      CGAL::parameters::get_cost(sms::LindstromTurk_cost<Mesh>()).get_placement(sms::LindstromTurk_placement<Mesh>()));
  return {std::move(watch.kept), watch.seconds};
}

}  // namespace tintree::bench
