#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "codec/mesh_codec.h"
#include "tests/bench/rivals/coded_size.h"
#include "tests/bench/rivals/cpu_clock.h"

namespace tintree::bench {
namespace {

constexpr double kOnLattice = 1e-4;  // of a step

std::optional<std::int32_t> address(double steps) {
  const double whole = std::round(steps);
  if (std::abs(steps - whole) > kOnLattice) return std::nullopt;
  return static_cast<std::int32_t>(whole);
}

std::optional<codec::TileMesh> on_lattice(const HeightGrid& grid, const TriangleMesh& mesh, int xy_shift,
                                          double height_step_m) {
  const double units = std::ldexp(1.0, -xy_shift);
  double floor_steps = std::numeric_limits<double>::infinity();
  for (const auto& v : mesh.vertices) floor_steps = std::min(floor_steps, std::round(v[2] / height_step_m));
  codec::TileMesh out;
  out.xy_shift = xy_shift;
  for (const auto& [x, y, z] : mesh.vertices) {
    const auto column = address(x / grid.dx_m * units);
    const auto row = address(-y / grid.dy_m * units);
    const auto height = address(z / height_step_m - floor_steps);
    if (!column || !row || !height) return std::nullopt;
    out.vertices.push_back({*column, *row, *height});
  }
  out.triangles = mesh.triangles;
  return out;
}

}  // namespace

Expected<CodedMesh> code_mesh(const HeightGrid& grid, const TriangleMesh& mesh, double height_step_m) {
  auto tile = on_lattice(grid, mesh, 0, height_step_m);
  if (!tile) tile = on_lattice(grid, mesh, -3, height_step_m);
  if (!tile) return fail(ErrorCode::kBadData, "a vertex lies off the lattice that was named", "--height-step");
  const codec::MeshCodec& codec = *codec::find_codec("tin");
  const auto bytes = codec.encode(*tile);
  if (!bytes) return tl::unexpected(bytes.error());
  if (const auto decoded = codec.decode(*bytes); !decoded) return tl::unexpected(decoded.error());
  return CodedMesh{bytes->size(), least_seconds([&] { (void)codec.decode(*bytes); })};
}

}  // namespace tintree::bench
