#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "tests/bench/rivals/cpu_clock.h"
#include "tests/bench/rivals/simplifiers.h"

namespace tintree::bench {
namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

Mesh to_openmesh(const TriangleMesh& mesh) {
  Mesh out;
  for (const auto& v : mesh.vertices) {
    out.add_vertex({static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])});
  }
  for (const auto& t : mesh.triangles) {
    out.add_face(Mesh::VertexHandle(static_cast<int>(t[0])), Mesh::VertexHandle(static_cast<int>(t[1])),
                 Mesh::VertexHandle(static_cast<int>(t[2])));
  }
  return out;
}

}  // namespace

Simplified openmesh(const HeightGrid& grid, double error_m) {
  const TriangleMesh full = full_mesh(grid);
  Mesh mesh = to_openmesh(full);

  const CpuClock clock;
  mesh.request_face_normals();
  mesh.update_face_normals();
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModHausdorffT<Mesh>::Handle hausdorff;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(hausdorff);
  decimater.add(flipping);
  decimater.module(hausdorff).set_tolerance(static_cast<float>(error_m));
  decimater.initialize();
  decimater.decimate();
  const double seconds = clock.seconds();

  // Half-edge collapse moves no vertex: their numbers still name the grid's samples.
  TriangleMesh out{full.vertices, {}};
  for (const auto face : mesh.faces()) {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t k = 0;
    for (const auto v : face.vertices()) triangle[k++] = static_cast<std::uint32_t>(v.idx());
    out.triangles.push_back(triangle);
  }
  return {compacted(out), seconds};
}

}  // namespace tintree::bench
