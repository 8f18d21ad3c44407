#include "apps/export/export_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "apps/export/mesh_writer.h"
#include "apps/export/tile_cut.h"
#include "apps/export/vertex_merger.h"

namespace tintree::exporter {
namespace {

/// Vertex numbers are stored as signed 32-bit integers in PLY.
constexpr std::uint64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

class Exporter {
 public:
  Exporter(const cache::TileStore& store, MeshWriter& writer)
      : store_(store), writer_(writer), merger_(store.manifest().layout) {}

  Expected<void> add(const codec::TileId& id) {
    const auto tile = store_.read(id);
    if (!tile) return tl::unexpected(tile.error());
    const auto mesh = store_.decode(*tile);
    if (!mesh) return fail(mesh.error().code, mesh.error().text(), store_.path());
    if (summary_.vertices + mesh->vertices.size() > kMaxVertices) {
      return fail(ErrorCode::kUsage,
                  "the mesh has more vertices than the format can count; choose a coarser --level or --error");
    }
    add_mesh(id, *mesh);
    ++summary_.tiles;
    summary_.triangles += mesh->triangles.size();
    summary_.error_m = std::max(summary_.error_m, tile->info.error_m);
    return writer_.ok();
  }

  const ExportSummary& summary() const { return summary_; }

 private:
  void add_mesh(const codec::TileId& id, const codec::TileMesh& mesh) {
    const codec::GridFrame frame(store_.manifest().layout, id, mesh);
    numbers_.clear();
    for (const codec::GridVertex& v : mesh.vertices) {
      const auto next = static_cast<std::uint32_t>(summary_.vertices);
      const auto met = merger_.merge(id, frame, v, next);
      numbers_.push_back(met.value_or(next));
      if (met) continue;
      std::array<double, 3> p = frame.world(v);
      for (double& coordinate : p) coordinate += 0.0;  // no negative zeros
      writer_.add_vertex(p);
      ++summary_.vertices;
    }
    for (const codec::Triangle& t : mesh.triangles) writer_.add_face({numbers_[t[0]], numbers_[t[1]], numbers_[t[2]]});
  }

  const cache::TileStore& store_;
  MeshWriter& writer_;
  VertexMerger merger_;
  ExportSummary summary_;
  std::vector<std::uint32_t> numbers_;
};

/// The name that opens a WKT definition.
std::string crs_name(const std::string& wkt) {
  const std::size_t begin = wkt.find('"');
  const std::size_t end = begin == std::string::npos ? begin : wkt.find('"', begin + 1);
  return end == std::string::npos ? "none stated" : wkt.substr(begin + 1, end - begin - 1);
}

/// Metres per unit of the CRS, eastward and northward: a step of the grid measured in both.
std::array<double, 2> metres_per_unit(const cache::Manifest& m) {
  const auto& gt = m.geotransform;
  const auto column = m.layout.world(1, 0);
  const auto row = m.layout.world(0, 1);
  const auto ratio = [](double a_m, double a, double b_m, double b) {
    return std::abs(a) > std::abs(b) ? a_m / a : b_m / b;
  };
  return {ratio(column[0], gt[1], row[0], gt[2]), ratio(row[1], gt[5], column[1], gt[4])};
}

}  // namespace

std::vector<std::string> describe(const cache::TileStore& store, const ExportOptions& options) {
  const cache::Manifest& m = store.manifest();
  const auto& gt = m.geotransform;
  const char* unit = m.geographic ? " (degrees)" : "";
  std::vector<std::string> lines;
  lines.emplace_back(options.level ? fmt::format("tintree export of level {}, error at most {} m", *options.level,
                                                 m.layout.bound_m(*options.level))
                                   : fmt::format("tintree export within {} m", options.error_m.value_or(0)));
  for (const cache::InputFile& input : m.inputs) lines.push_back("elevation model: " + input.path);
  lines.emplace_back("x east, y north, z up, in metres from the origin; z is the height itself");
  lines.push_back(
      fmt::format("origin: centre of the first sample, the north-west one unless the grid is rotated; "
                  "CRS coordinates {} {}{}",
                  gt[0] + (gt[1] + gt[2]) / 2, gt[3] + (gt[4] + gt[5]) / 2, unit));
  lines.push_back("CRS: " + crs_name(m.crs_wkt));
  const auto [east_m, north_m] = metres_per_unit(m);
  lines.push_back(fmt::format("CRS coordinates of a vertex: origin + (x / {}, y / {}){}", east_m, north_m, unit));
  for (std::string& line : lines)
    std::ranges::replace_if(
        line, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return lines;
}

Expected<ExportSummary> export_tree(const cache::TileStore& store, const ExportOptions& options) {
  const auto tiles =
      options.level ? tiles_of_level(store, *options.level) : tiles_within(store, options.error_m.value_or(0));
  if (!tiles) return tl::unexpected(tiles.error());
  auto writer = create_mesh_writer(options.format, options.path, describe(store, options));
  if (!writer) return tl::unexpected(writer.error());
  Exporter exporter(store, **writer);
  for (std::size_t i = 0; i < tiles->size(); ++i) {
    if (options.progress && !options.progress(i, tiles->size())) {
      return fail(ErrorCode::kStopped, "stopped; nothing was written", options.path);
    }
    if (auto added = exporter.add((*tiles)[i]); !added) return tl::unexpected(added.error());
  }
  if (options.progress) options.progress(tiles->size(), tiles->size());
  if (auto finished = (*writer)->finish(); !finished) return tl::unexpected(finished.error());
  return exporter.summary();
}

}  // namespace tintree::exporter
