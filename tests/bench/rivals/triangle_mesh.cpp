#include "tests/bench/rivals/triangle_mesh.h"

#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include <fmt/format.h>

namespace tintree::bench {
namespace {

constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);

}  // namespace

TriangleMesh full_mesh(const HeightGrid& grid) {
  TriangleMesh mesh;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      mesh.vertices.push_back({column * grid.dx_m, -row * grid.dy_m, grid.at(column, row)});
    }
  }
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const auto nw = static_cast<std::uint32_t>(row * grid.columns + column);
      const auto sw = nw + static_cast<std::uint32_t>(grid.columns);
      if (grid.has_lower(column, row)) mesh.triangles.push_back({nw, sw, sw + 1});
      if (grid.has_upper(column, row)) mesh.triangles.push_back({nw, sw + 1, nw + 1});
    }
  }
  return grid.has_holes() ? compacted(mesh) : mesh;
}

TriangleMesh compacted(const TriangleMesh& mesh) {
  constexpr auto kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_index(mesh.vertices.size(), kUnused);
  TriangleMesh out;
  for (auto triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) {
      if (new_index[v] == kUnused) {
        new_index[v] = static_cast<std::uint32_t>(out.vertices.size());
        out.vertices.push_back(mesh.vertices[v]);
      }
      v = new_index[v];
    }
    out.triangles.push_back(triangle);
  }
  return out;
}

Expected<TriangleMesh> read_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::size_t vertices = 0;
  std::size_t faces = 0;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    constexpr std::string_view kVertex = "element vertex ";
    constexpr std::string_view kFace = "element face ";
    if (line.starts_with(kVertex)) vertices = std::stoull(line.substr(kVertex.size()));
    if (line.starts_with(kFace)) faces = std::stoull(line.substr(kFace.size()));
  }
  TriangleMesh mesh;
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(faces);
  file.read(reinterpret_cast<char*>(mesh.vertices.data()), static_cast<std::streamsize>(vertices * 3 * sizeof(double)));
  std::vector<char> records(faces * kFaceBytes);
  file.read(records.data(), static_cast<std::streamsize>(records.size()));
  if (!file || faces == 0) return fail(ErrorCode::kBadData, "is no PLY file of doubles and triangles", path);
  for (std::size_t i = 0; i < faces; ++i) {
    std::memcpy(mesh.triangles[i].data(), records.data() + i * kFaceBytes + 1, kFaceBytes - 1);
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (v >= vertices) return fail(ErrorCode::kBadData, "names a vertex that is not there", path);
    }
  }
  return mesh;
}

Expected<void> write_ply(const std::string& path, const TriangleMesh& mesh) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  file.write(reinterpret_cast<const char*>(mesh.vertices.data()),
             static_cast<std::streamsize>(mesh.vertices.size() * 3 * sizeof(double)));
  for (const auto& triangle : mesh.triangles) {
    std::array<char, kFaceBytes> record{3};
    std::memcpy(record.data() + 1, triangle.data(), kFaceBytes - 1);
    file.write(record.data(), record.size());
  }
  file.close();
  if (!file) return fail(ErrorCode::kIo, "cannot be written", path);
  return {};
}

}  // namespace tintree::bench
