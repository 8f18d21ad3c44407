#include "apps/audit/hausdorff.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Surface_mesh.h>

namespace tintree::audit {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh to_cgal(const TriangleSoup& soup) {
  Mesh mesh;
  const auto faces = static_cast<Mesh::size_type>(soup.size());
  mesh.reserve(3 * faces, 3 * faces, faces);
  for (const auto& t : soup) {
    const auto vertex = [&mesh](const Point& p) { return mesh.add_vertex(Kernel::Point_3(p[0], p[1], p[2])); };
    mesh.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2]));
  }
  return mesh;
}

}  // namespace

double symmetric_hausdorff(const TriangleSoup& one, const TriangleSoup& other, double error_bound) {
  const Mesh a = to_cgal(one);
  const Mesh b = to_cgal(other);
  const auto parameters = CGAL::parameters::match_faces(false);
  return CGAL::Polygon_mesh_processing::bounded_error_symmetric_Hausdorff_distance<CGAL::Sequential_tag>(
      a, b, error_bound, parameters, CGAL::parameters::default_values());
}

}  // namespace tintree::audit
