/// The audit of real trees of every method with one thing wrong: a vertex, a triangle, a border, a figure, a byte.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "simplify/tile_maker.h"
#include "tests/support/naive_measure.h"
#include "tests/support/regular_tree.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::test {
namespace {

using codec::TileId;
using codec::TileMesh;
using nlohmann::json;

struct Method {
  std::string name;
  std::string effort = "fast";

  friend std::ostream& operator<<(std::ostream& out, const Method& m) { return out << m.name << '_' << m.effort; }
};

template <typename T>
T value_of(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().text());
  return std::move(*expected);
}

class AuditMutationTest : public testing::TestWithParam<Method> {
 protected:
  AuditMutationTest() : dem_(dir_.file("dem.tif")), path_(dir_.file("tree.tintree")) {
    write_raster(dem_, {.columns = 50, .rows = 41, .dx = 10, .dy = 10}, [](int c, int r) { return hills(c, r); });
    grid_ = read_grid(dem_);
    const ProgramResult built =
        run_program(TINTREE_BUILD, {dem_, "-o", path_, "--quiet", "--tile", "16", "--error", "1", "--method",
                                    GetParam().name, "--effort", GetParam().effort});
    if (built.exit_code != 0) throw std::runtime_error(built.all());
    const auto store = value_of(cache::TileStore::open(path_));
    tree_.manifest = store.manifest();
    for (const cache::TileNode& node : store.bounds().nodes()) tree_.tiles.push_back(value_of(store.read(node.id)));
    std::ranges::sort(tree_.tiles, {}, [](const cache::StoredTile& t) { return t.info.id.key(); });
    source_ = std::make_shared<cache::RasterSource>(value_of(cache::RasterSource::open({dem_})));
    surface_ = value_of(simplify::ReferenceSurface::scan(std::make_shared<cache::HeightBlocks>(source_, 1 << 20),
                                                         [](std::uint64_t, std::uint64_t) { return true; }));
    maker_ = simplify::make_tile_maker(tree_.manifest, *surface_);
  }

  /// Stores the mesh with the figures that it really has; false, and nothing stored, where the method's code cannot
  /// hold it.
  bool put(const TileId& id, const TileMesh& mesh) {
    const auto payload = maker_->encode(*codec::find_codec(tree_.manifest.method), id, mesh);
    if (!payload) return false;
    cache::StoredTile changed{tree_.tile(id).info, *payload};
    const auto stored = decode(changed);
    if (!stored || stored->triangles.size() != mesh.triangles.size()) return false;
    const NaiveFigures f = naive_figures(grid_, tree_.manifest.layout, id, *stored);
    changed.info = {id,
                    static_cast<std::uint32_t>(stored->vertices.size()),
                    static_cast<std::uint32_t>(stored->triangles.size()),
                    f.z_min_m,
                    f.z_max_m,
                    f.error_m,
                    f.rms_m,
                    f.border_error_m};
    tree_.tile(id) = changed;
    return true;
  }

  Expected<TileMesh> decode(const cache::StoredTile& tile) {
    return cache::TileDecoder(tree_.manifest,
                              [this](const TileId& id) { return Expected<cache::StoredTile>(tree_.tile(id)); })
        .decode(tile);
  }
  TileMesh mesh(const TileId& id) { return value_of(decode(tree_.tile(id))); }

  /// A vertex on a sample, alone at its place.
  struct Vertex {
    std::size_t index = 0;
    double above_m = 0;  ///< Over the sample.
  };
  /// Those inside the tile, or those on its west side without the corners.
  std::vector<Vertex> vertices(const TileId& id, const TileMesh& mesh, bool on_side) const {
    const codec::GridFrame frame(tree_.manifest.layout, id, mesh);
    const codec::CellRect cells = tree_.manifest.layout.cells(id);
    std::map<std::pair<std::int32_t, std::int32_t>, int> at_place;
    for (const codec::GridVertex& v : mesh.vertices) ++at_place[{v.x, v.y}];
    std::vector<Vertex> found;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const codec::GridVertex& v = mesh.vertices[i];
      const auto c = static_cast<std::int64_t>(frame.column(v.x));
      const auto r = static_cast<std::int64_t>(frame.row(v.y));
      const bool on_sample = static_cast<double>(c) == frame.column(v.x) && static_cast<double>(r) == frame.row(v.y);
      const bool within = r > cells.row0 && r < cells.row1 && c < cells.column1;
      if (!on_sample || !within || (c == cells.column0) != on_side || at_place[{v.x, v.y}] > 1) continue;
      found.push_back({i, frame.height_m(v.z) - grid_.at(c, r)});
    }
    return found;
  }

  /// Moves a vertex away from its sample by 1.01 bounds.
  bool move_vertex(const TileId& id) {
    const codec::TreeLayout& layout = tree_.manifest.layout;
    const TileMesh whole = mesh(id);
    const double bound_m = layout.bound_m(id.level);
    const auto steps =
        static_cast<std::int32_t>(std::ceil(1.01 * bound_m / layout.z_step_m[static_cast<std::size_t>(id.level)]));
    return std::ranges::any_of(vertices(id, whole, false), [&](const Vertex& v) {
      TileMesh moved = whole;
      moved.vertices[v.index].z += v.above_m < 0 ? -steps : steps;
      return put(id, moved) && tree_.tile(id).info.error_m > bound_m;
    });
  }

  /// Moves a vertex of the west side towards its sample by one height step: the tile keeps its bound, but meets its
  /// neighbour no more.
  bool shift_border_vertex(const TileId& id) {
    const TileMesh whole = mesh(id);
    return std::ranges::any_of(vertices(id, whole, true), [&](const Vertex& v) {
      TileMesh shifted = whole;
      shifted.vertices[v.index].z += v.above_m > 0 ? -1 : 1;
      return put(id, shifted);
    });
  }

  /// Drops a triangle; or, where the method has a word for missing vertices only, all triangles round one.
  bool drop_triangles(const TileId& id) {
    const TileMesh whole = mesh(id);
    for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
      TileMesh less = whole;
      less.triangles.erase(less.triangles.begin() + static_cast<std::ptrdiff_t>(t));
      if (put(id, less)) return true;
    }
    return std::ranges::any_of(vertices(id, whole, false), [&](const Vertex& v) {
      return put(id, without_vertex(whole, static_cast<std::uint32_t>(v.index)));
    });
  }

  static TileMesh without_vertex(TileMesh mesh, std::uint32_t vertex) {
    std::erase_if(mesh.triangles, [&](const codec::Triangle& t) { return std::ranges::find(t, vertex) != t.end(); });
    const auto at = static_cast<std::ptrdiff_t>(vertex);
    if (!mesh.nested_levels.empty()) {
      mesh.nested_gaps.push_back({mesh.vertices[vertex].x, mesh.vertices[vertex].y, mesh.nested_levels[vertex]});
      mesh.nested_levels.erase(mesh.nested_levels.begin() + at);
    }
    mesh.vertices.erase(mesh.vertices.begin() + at);
    for (codec::Triangle& t : mesh.triangles) {
      for (std::uint32_t& v : t) v -= v > vertex ? 1 : 0;
    }
    return mesh;
  }

  /// Flips a bit of the tile's payload in the written file, near its end: its beginning may be on another page.
  void flip_bit(const TileId& id) const {
    const std::vector<std::byte>& payload =
        tree_
            .tiles[static_cast<std::size_t>(
                std::ranges::find(tree_.tiles, id, [](const auto& t) { return t.info.id; }) - tree_.tiles.begin())]
            .payload;
    const std::size_t length = std::min<std::size_t>(24, payload.size());
    const std::string tail(reinterpret_cast<const char*>(payload.data()) + payload.size() - length, length);
    std::string file = read_file(path_);
    const std::size_t at = file.find(tail);
    ASSERT_NE(at, std::string::npos);
    file[at + length / 2] = static_cast<char>(file[at + length / 2] ^ 0x10);
    write_file(path_, file);
  }

  json audit(int exit_code) const {
    const std::string report = dir_.file("report.json");
    const ProgramResult r =
        run_program(TINTREE_AUDIT, {path_, "--dem", dem_, "--quiet", "--hausdorff-tiles", "0", "--json", report});
    EXPECT_EQ(r.exit_code, exit_code) << r.all();
    return json::parse(read_file(report)).at("violation_list");
  }

  TempDir dir_;
  std::string dem_;
  std::string path_;
  HeightGrid grid_;
  TestTree tree_;
  std::shared_ptr<cache::RasterSource> source_;
  std::unique_ptr<simplify::ReferenceSurface> surface_;
  std::unique_ptr<simplify::TileMaker> maker_;
};

TEST_P(AuditMutationTest, PassesWhatIsWrittenAgain) {
  for (const TileId& id : {TileId{2, 1, 1}, TileId{1, 1, 0}, TileId{0, 0, 0}}) EXPECT_TRUE(put(id, mesh(id)));
  write_tree(path_, tree_);
  const json found = audit(0);
  EXPECT_TRUE(found.empty()) << found.dump(1);
}

TEST_P(AuditMutationTest, FindsAndNamesEveryChange) {
  std::vector<std::pair<TileId, std::string>> changes;
  // On all levels, those included whose tiles others build on.
  for (const TileId& id : {TileId{2, 1, 1}, TileId{1, 1, 0}, TileId{0, 0, 0}}) {
    ASSERT_TRUE(move_vertex(id)) << id.text();
    changes.emplace_back(id, "bound");
  }
  ASSERT_TRUE(drop_triangles({2, 0, 1}));
  changes.emplace_back(TileId{2, 0, 1}, "coverage");
  ASSERT_TRUE(shift_border_vertex({2, 2, 0}));
  changes.emplace_back(TileId{2, 2, 0}, "border");
  tree_.tile({1, 0, 0}).info.error_m -= 0.01;
  changes.emplace_back(TileId{1, 0, 0}, "stored_figure");
  write_tree(path_, tree_);
  flip_bit({2, 2, 2});
  changes.emplace_back(TileId{2, 2, 2}, "file");

  const json found = audit(1);
  for (const auto& [id, kind] : changes) {
    EXPECT_TRUE(std::ranges::any_of(
        found,
        [&, &id = id, &kind = kind](const json& v) { return v.at("kind") == kind && v.at("tile") == id.text(); }))
        << kind << " of tile " << id.text() << " not in " << found.dump(1);
  }
  for (const json& v : found) EXPECT_NE(v.at("tile"), "2/3/1") << "nothing is wrong there: " << v.dump(1);
}

INSTANTIATE_TEST_SUITE_P(Methods, AuditMutationTest,
                         testing::Values(Method{"tin"}, Method{"tin", "best"}, Method{"strip"}, Method{"strip", "best"},
                                         Method{"nested"}, Method{"wavelet"}, Method{"scalar"}),
                         [](const auto& method) { return testing::PrintToString(method.param); });

}  // namespace
}  // namespace tintree::test
