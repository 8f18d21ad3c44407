#include "apps/audit/topology.h"

#include <array>

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <fmt/format.h>

namespace tintree::audit {
namespace {

/// Connectivity alone: places are known from the surface.
using HalfEdgeMesh = OpenMesh::TriConnectivity;

std::string place_text(const TileSurface& s, std::uint32_t vertex) {
  const Corner& p = s.corners[vertex];
  return fmt::format("at ({:.10g}, {:.10g}) of the tile", static_cast<double>(p.x) / s.units,
                     static_cast<double>(p.y) / s.units);
}

void silence_openmesh() {
  // It reports refused triangles on its error stream; they come back as faults instead.
  [[maybe_unused]] static const bool done = [] {
    omerr().disable();
    omlog().disable();
    omout().disable();
    return true;
  }();
}

}  // namespace

Faults check_topology(const TileSurface& s) {
  silence_openmesh();
  Faults faults;
  HalfEdgeMesh mesh;
  mesh.reserve(s.corners.size(), s.edges.size(), s.triangles.size());
  mesh.resize(s.corners.size(), 0, 0);
  const auto handle = [](std::uint32_t v) { return HalfEdgeMesh::VertexHandle(static_cast<int>(v)); };
  for (const codec::Triangle& t : s.triangles) {
    const std::array<HalfEdgeMesh::VertexHandle, 3> corners{handle(t[0]), handle(t[1]), handle(t[2])};
    if (!mesh.add_face(corners.data(), corners.size()).is_valid()) {
      faults.add("a triangle does not fit its neighbours (edge used twice the same way or by three) " +
                 place_text(s, t[0]));
    }
  }
  if (s.overused_edges > 0 && faults.count == 0) faults.add("an edge has more than two triangles");
  for (std::uint32_t v = 0; v < s.corners.size(); ++v) {
    if (mesh.is_isolated(handle(v))) {
      if (faults.count == 0) faults.add("a vertex has no triangle " + place_text(s, v));
    } else if (!mesh.is_manifold(handle(v))) {
      faults.add("a vertex joins several fans of triangles " + place_text(s, v));
    }
  }
  return faults;
}

}  // namespace tintree::audit
