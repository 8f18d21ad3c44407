#include "tests/simplify/whole_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"

namespace tintree::test {
namespace {

using codec::TileId;

/// An edge on a side of a tile: begin and end along the side in eighths of a sample, and global height addresses.
struct SideEdge {
  std::int64_t begin;
  std::int64_t end;
  std::int64_t begin_height;
  std::int64_t end_height;

  friend bool operator==(const SideEdge&, const SideEdge&) = default;
};

std::ostream& operator<<(std::ostream& out, const SideEdge& e) {
  return out << "eighths " << e.begin << " to " << e.end << " at heights " << e.begin_height << " to " << e.end_height;
}

/// Collects the sides of a level's tiles and compares each with the other tile's at the same place.
class BorderCheck {
 public:
  void add(const codec::TreeLayout& layout, const TileId& id, const codec::TileMesh& mesh) {
    const codec::GridFrame frame(layout, id, mesh);
    const auto eighths = [](double samples) { return static_cast<std::int64_t>(samples * 8); };
    const std::int64_t across = 8 * layout.cells_across(id.level);
    const auto place = [&](std::uint32_t v, bool vertical) {
      const codec::GridVertex& p = mesh.vertices[v];
      return vertical ? std::pair{eighths(frame.column(p.x)), eighths(frame.row(p.y))}
                      : std::pair{eighths(frame.row(p.y)), eighths(frame.column(p.x))};
    };
    for (const auto& [a, b] : open_edges(mesh)) {
      for (const bool vertical : {false, true}) {
        const auto [line, from] = place(a, vertical);
        const auto [other_line, to] = place(b, vertical);
        if (line != other_line || line % across != 0) continue;
        const std::int64_t from_height = mesh.z_offset + mesh.vertices[a].z;
        const std::int64_t to_height = mesh.z_offset + mesh.vertices[b].z;
        note(id, vertical, line,
             from < to ? SideEdge{from, to, from_height, to_height} : SideEdge{to, from, to_height, from_height});
      }
    }
  }

  static std::set<std::pair<std::uint32_t, std::uint32_t>> open_edges(const codec::TileMesh& mesh) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const codec::Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (edges.erase({t[(k + 1) % 3], t[k]}) == 0) edges.insert({t[k], t[(k + 1) % 3]});
      }
    }
    return edges;
  }

 private:
  /// Where two tiles have surface along a line, both must have the same edge there.
  void note(const TileId& id, bool vertical, std::int64_t line, const SideEdge& edge) {
    for (std::int64_t at = edge.begin; at < edge.end; ++at) {
      const auto [known, added] = edges_.try_emplace({id.level, vertical, line, at}, edge);
      if (added || known->second == edge) continue;
      ADD_FAILURE() << "neighbours differ on " << (vertical ? "column " : "row ") << line / 8 << " of level "
                    << id.level << ": " << known->second << ", but " << edge;
      return;
    }
  }

  std::map<std::tuple<int, bool, std::int64_t, std::int64_t>, SideEdge> edges_;
};

/// Every open edge runs along the outline of the tile's cells, once round.
void expect_outline_of(const codec::CellRect& cells, const codec::TreeLayout& layout, const TileId& id,
                       const codec::TileMesh& mesh) {
  const codec::GridFrame frame(layout, id, mesh);
  double length = 0;
  for (const auto& [a, b] : BorderCheck::open_edges(mesh)) {
    const double c0 = frame.column(mesh.vertices[a].x);
    const double c1 = frame.column(mesh.vertices[b].x);
    const double r0 = frame.row(mesh.vertices[a].y);
    const double r1 = frame.row(mesh.vertices[b].y);
    const auto on = [](double p, double q, std::int64_t low, std::int64_t high) {
      return p == q && (p == static_cast<double>(low) || p == static_cast<double>(high));
    };
    EXPECT_TRUE(on(c0, c1, cells.column0, cells.column1) || on(r0, r1, cells.row0, cells.row1));
    length += std::abs(c1 - c0) + std::abs(r1 - r0);
  }
  EXPECT_EQ(length, static_cast<double>(2 * (cells.column1 - cells.column0 + cells.row1 - cells.row0)));
}

/// What rounding in double may do to brute force itself, over heights this large.
double slack_m(double height_m) { return 1e-14 * height_m; }

void expect_sound_stored_tile(const Terrain& terrain, const WholeTree& tree, const TileId& id,
                              const codec::TileMesh& mesh) {
  const codec::TreeLayout& layout = tree.store.manifest().layout;
  const codec::CellRect cells = layout.cells(id);
  expect_sound_mesh(terrain.grid, layout, id, mesh);
  if (testing::Test::HasFatalFailure()) return;
  if (half_cells(terrain.grid, cells) == 2 * (cells.column1 - cells.column0) * (cells.row1 - cells.row0)) {
    expect_outline_of(cells, layout, id, mesh);
  }
  const auto tile = tree.store.read(id);
  ASSERT_TRUE(tile.has_value()) << tile.error().text();
  const Overlay found = overlay(terrain.grid, layout, id, mesh);
  const double bound = layout.bound_m(id.level);
  const double slack =
      slack_m(std::max(std::abs(tile->info.z_min_m), std::abs(tile->info.z_max_m)) + found.max_m) + 1e-9 * bound;
  EXPECT_LE(found.coverage_error, 1e-9);
  EXPECT_LE(found.max_m, bound + slack);
  EXPECT_LE(tile->info.error_m, bound);
  EXPECT_NEAR(tile->info.error_m, found.max_m, slack);
  EXPECT_NEAR(tile->info.border_error_m, found.border_max_m, slack);
  EXPECT_NEAR(tile->info.rms_m, found.rms_m, slack);
  EXPECT_EQ(tile->info.vertices, mesh.vertices.size());
  EXPECT_EQ(tile->info.triangles, mesh.triangles.size());
}

}  // namespace

Expected<WholeTree> build_whole_tree(const Terrain& terrain, const codec::TreeLayout& layout, const std::string& path,
                                     const std::string& effort, const std::string& method,
                                     const std::string& quantizer) {
  const auto go_on = [](const std::string&, std::uint64_t, std::uint64_t) { return true; };
  cache::Manifest manifest;
  manifest.method = method;
  manifest.quantizer = quantizer;
  manifest.layout = layout;
  manifest.effort = effort;
  manifest.method = method;
  manifest.geotransform = {0, 1, 0, 0, 0, -1};
  manifest.inputs = {{"dem.tif", 1, 1}};
  manifest.samples_digest = terrain.surface->digest();
  auto writer = cache::TileWriter::create(path, manifest);
  if (!writer) return tl::unexpected(writer.error());
  auto levels = simplify::make_tiles(*terrain.surface, manifest, *writer, go_on);
  if (!levels) return tl::unexpected(levels.error());
  if (auto measured = simplify::measure_tiles(*terrain.surface, manifest, *writer, *levels, go_on); !measured) {
    return tl::unexpected(measured.error());
  }
  if (auto finished = writer->finish(); !finished) return tl::unexpected(finished.error());
  auto store = cache::TileStore::open(path);
  if (!store) return tl::unexpected(store.error());
  return WholeTree{std::move(*store), std::move(*levels)};
}

double accepted_error_m(const Terrain& terrain, int tile_cells, double wished_m) {
  const auto layout = plan_layout(terrain, tile_cells, wished_m);
  if (layout) return wished_m;
  EXPECT_EQ(layout.error().code, ErrorCode::kBadData);
  const std::string text = layout.error().text();
  const auto at = text.find("--error ");
  if (at == std::string::npos) {
    ADD_FAILURE() << "says nothing to do: " << text;
    return wished_m;
  }
  const double advised_m = std::stod(text.substr(at + 8));
  EXPECT_GT(advised_m, wished_m) << text;
  EXPECT_TRUE(plan_layout(terrain, tile_cells, advised_m).has_value()) << "the advice does not help: " << text;
  return advised_m;
}

void expect_sound_tree(const Terrain& terrain, const WholeTree& tree) {
  const codec::TreeLayout& layout = tree.store.manifest().layout;
  BorderCheck borders;
  for (const TileId& id : tiles_of(layout)) {
    SCOPED_TRACE("tile " + id.text());
    const bool has_surface = half_cells(terrain.grid, layout.cells(id)) > 0;
    ASSERT_EQ(tree.store.bounds().find(id) >= 0, has_surface);
    if (!has_surface) continue;
    const auto mesh = tree.store.read_mesh(id);
    ASSERT_TRUE(mesh.has_value()) << mesh.error().text();
    expect_sound_stored_tile(terrain, tree, id, *mesh);
    borders.add(layout, id, *mesh);
    if (testing::Test::HasFailure()) return;
  }
}

Terrain open_terrain(const AdversarialTerrain& shape) {
  const TempDir dir;
  write_terrain(dir.file("dem.tif"), shape);
  return read_terrain(dir.file("dem.tif"));
}

void expect_sound_build(const Terrain& terrain, int tile_cells, double wished_error_m, const std::string& method,
                        const std::string& effort) {
  const double error_m = accepted_error_m(terrain, tile_cells, wished_error_m);
  SCOPED_TRACE(testing::Message() << "tile " << tile_cells << ", error " << error_m << " m");
  const TempDir dir;
  const auto tree =
      build_whole_tree(terrain, make_layout(terrain, tile_cells, error_m), dir.file("t.tintree"), effort, method);
  ASSERT_TRUE(tree.has_value()) << tree.error().text();
  expect_sound_tree(terrain, *tree);
}

}  // namespace tintree::test
