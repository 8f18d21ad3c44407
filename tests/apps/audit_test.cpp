/// The audit as a program: good trees pass, and every kind of damage is found and named.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sqlite3.h>
#include <xxhash.h>

#include "tests/support/naive_measure.h"
#include "tests/support/regular_tree.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::test {
namespace {

using nlohmann::json;

double holed_hills(int c, int r) {
  const bool hole = (c > 20 && c < 26 && r > 9 && r < 18) || (c == 31 && r == 32) || (c == 33 && r == 33);
  return hole ? kMissing : hills(c, r);
}

class AuditTest : public testing::Test {
 protected:
  AuditTest() : dem_(dir_.file("dem.tif")), path_(dir_.file("tree.tintree")) {
    write_raster(dem_, {.columns = 50, .rows = 41, .dx = 10, .dy = 10}, [](int c, int r) { return hills(c, r); });
    tree_ = make_regular_tree(dem_, {.tile_cells = 16});
  }

  ProgramResult audit(std::vector<std::string> more = {"--hausdorff-tiles", "0"}) const {
    more.insert(more.begin(), {path_, "--dem", dem_, "--quiet"});
    return run_program(TINTREE_AUDIT, more);
  }

  /// Writes the tree and expects the audit to fail, naming the tile and saying `what`.
  void expect_found(const codec::TileId& id, const std::string& what) {
    write_tree(path_, tree_);
    expect_found_in_file(id, what);
  }
  void expect_found_in_file(const codec::TileId& id, const std::string& what) const {
    const std::string report = dir_.file("report.json");
    const ProgramResult r = audit({"--hausdorff-tiles", "0", "--json", report});
    EXPECT_EQ(r.exit_code, 1) << r.all();
    EXPECT_NE(r.out.find("FAIL: "), std::string::npos) << r.out;
    EXPECT_NE(r.err.find("tile " + id.text()), std::string::npos) << r.err;
    const json found = json::parse(read_file(report));
    EXPECT_GT(found.at("violations").get<int>(), 0);
    EXPECT_EQ(found.at("worst_tile"), id.text());
    bool named = false;
    for (const json& v : found.at("violation_list"))
      named = named || (v.at("kind") == what && v.at("tile") == id.text());
    EXPECT_TRUE(named) << what << " not in " << found.at("violation_list").dump(1);
  }

  /// Fills in the figures that the tile's mesh, as it is now, really has.
  void measure_again(const codec::TileId& id) {
    const NaiveFigures f = naive_figures(read_grid(dem_), tree_.manifest.layout, id, tree_.mesh(id));
    cache::TileInfo& info = tree_.tile(id).info;
    info.error_m = f.error_m;
    info.rms_m = f.rms_m;
    info.border_error_m = f.border_error_m;
    info.z_min_m = f.z_min_m;
    info.z_max_m = f.z_max_m;
  }

  /// Expects a violation of the file as a whole.
  void expect_file_found(const std::string& what) const {
    const std::string report = dir_.file("report.json");
    const ProgramResult r = audit({"--hausdorff-tiles", "0", "--json", report});
    EXPECT_EQ(r.exit_code, 1) << r.all();
    EXPECT_NE(r.err.find("file: "), std::string::npos) << r.err;
    const json found = json::parse(read_file(report));
    EXPECT_TRUE(found.at("worst_tile").is_null());
    EXPECT_EQ(found.at("violation_list")[0].at("kind"), what) << found.at("violation_list").dump(1);
    EXPECT_TRUE(found.at("violation_list")[0].at("tile").is_null());
  }

  void change_file(const std::string& sql, const std::string& blob = {}) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    sqlite3_stmt* statement = nullptr;
    ASSERT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    if (!blob.empty()) {
      sqlite3_bind_blob(statement, 1, blob.data(), static_cast<int>(blob.size()), SQLITE_STATIC);
      sqlite3_bind_int64(statement, 2, static_cast<sqlite3_int64>(XXH3_64bits(blob.data(), blob.size())));
    }
    ASSERT_EQ(sqlite3_step(statement), SQLITE_DONE) << sqlite3_errmsg(db);
    sqlite3_finalize(statement);
    sqlite3_close(db);
  }

  /// A float of one tile's record in the hierarchy of boxes, to be changed.
  struct BoundsChange {
    codec::TileId id;
    std::size_t offset = 0;  ///< In the record of 16 bytes.
    float value = 0;
  };

  /// Changes the written file's hierarchy, checksum and all, and expects the audit to notice.
  void expect_bounds_found(const BoundsChange& change, const codec::TileId& id, const std::string& what) const {
    std::vector<cache::TileInfo> infos;
    for (const cache::StoredTile& t : tree_.tiles) infos.push_back(t.info);
    const cache::TileBounds bounds(tree_.manifest.layout, infos);
    const std::vector<std::byte> bytes = bounds.to_bytes();
    std::string blob(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::memcpy(blob.data() + 16 * static_cast<std::size_t>(bounds.find(change.id)) + change.offset, &change.value, 4);
    change_file("UPDATE metadata SET value = ?, checksum = ? WHERE name = 'bounds'", blob);
    expect_found_in_file(id, what);
  }

  /// |mesh - DEM| at every sample that a tile of the level covers, by point location.
  std::vector<double> sample_errors(int level) const {
    const HeightGrid grid = read_grid(dem_);
    std::vector<double> errors;
    for (const cache::StoredTile& tile : tree_.tiles) {
      if (tile.info.id.level != level) continue;
      const codec::CellRect cells = tree_.manifest.layout.cells(tile.info.id);
      for (std::int64_t r = cells.row0; r <= cells.row1; ++r) {
        for (std::int64_t c = cells.column0; c <= cells.column1; ++c) {
          errors.push_back(
              std::abs(mesh_height(tile.info.id, static_cast<double>(c), static_cast<double>(r)) - grid.at(c, r)));
        }
      }
    }
    return errors;
  }

  double mesh_height(const codec::TileId& id, double column, double row) const {
    const codec::TileMesh mesh = tree_.mesh(id);
    const codec::GridFrame frame(tree_.manifest.layout, id, mesh);
    for (const codec::Triangle& t : mesh.triangles) {
      std::array<std::array<double, 3>, 3> p{};
      for (std::size_t k = 0; k < 3; ++k) {
        const codec::GridVertex& v = mesh.vertices[t[k]];
        p[k] = {frame.column(v.x), frame.row(v.y), frame.height_m(v.z)};
      }
      const auto side = [&](std::size_t a, std::size_t b) {
        return (p[b][0] - p[a][0]) * (row - p[a][1]) - (p[b][1] - p[a][1]) * (column - p[a][0]);
      };
      const std::array<double, 3> sides{side(0, 1), side(1, 2), side(2, 0)};
      // Rows run southward: counter-clockwise from above is clockwise here.
      if (std::ranges::max(sides) <= 1e-9) return plane_height(p, column, row);
    }
    return kMissing;
  }

  /// The largest distance between leaves and level 1 along the line between the two tiles of level 1 side by
  /// side, and along the one between those one above the other, in eighths of a sample.
  double leaf_gap() const {
    const codec::TreeLayout& layout = tree_.manifest.layout;
    double gap = 0;
    const auto compare = [&](const codec::TileId& coarse, const codec::TileId& fine, double column, double row) {
      gap = std::max(gap, std::abs(mesh_height(coarse, column, row) - mesh_height(fine, column, row)));
    };
    for (double k = 0; k <= static_cast<double>(layout.rows - 1); k += 0.5) {
      const auto y = static_cast<std::uint32_t>(std::min(k, static_cast<double>(layout.rows - 2))) / 16;
      compare({1, 0, y / 2}, {2, 2, y}, 32, k);
    }
    for (double k = 0; k <= static_cast<double>(layout.columns - 1); k += 0.5) {
      const auto x = static_cast<std::uint32_t>(std::min(k, static_cast<double>(layout.columns - 2))) / 16;
      compare({1, x / 2, 0}, {2, x, 2}, k, 32);
    }
    return gap;
  }

  /// An inner vertex of the tile, moved up.
  void raise_vertex(const codec::TileId& id, double by_m) {
    codec::TileMesh mesh = tree_.mesh(id);
    const auto inner =
        std::ranges::find_if(mesh.vertices, [](const codec::GridVertex& v) { return v.x == 8 && v.y == 8; });
    ASSERT_NE(inner, mesh.vertices.end());
    const double step = tree_.manifest.layout.z_step_m[static_cast<std::size_t>(id.level)];
    inner->z += static_cast<std::int32_t>(std::ceil(by_m / step));
    tree_.set_mesh(id, mesh);
  }

  TempDir dir_;
  std::string dem_;
  std::string path_;
  TestTree tree_;
};

TEST_F(AuditTest, PassesAGoodTree) {
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  const ProgramResult r = run_program(TINTREE_AUDIT, {path_, "--dem", dem_, "--json", report});
  EXPECT_EQ(r.exit_code, 0) << r.all();
  EXPECT_NE(r.out.find("PASS: "), std::string::npos) << r.out;
  const json found = json::parse(read_file(report));
  EXPECT_EQ(found.at("violations"), 0);
  EXPECT_TRUE(found.at("worst_tile").is_null());
  EXPECT_GT(found.at("samples_per_second").get<double>(), 0);
  EXPECT_GT(found.at("peak_rss_bytes").get<std::uint64_t>(), 0U);
  ASSERT_EQ(found.at("levels").size(), 3U);
  for (std::size_t l = 0; l < 3; ++l) {
    const json& level = found.at("levels")[l];
    EXPECT_EQ(level.at("level"), l);
    EXPECT_EQ(level.at("bound_m"), tree_.manifest.layout.bound_m(static_cast<int>(l)));
    double largest = 0;
    std::uint64_t triangles = 0;
    for (const cache::StoredTile& t : tree_.tiles) {
      if (t.info.id.level != static_cast<int>(l)) continue;
      largest = std::max(largest, t.info.error_m);
      triangles += t.info.triangles;
    }
    EXPECT_NEAR(level.at("vertical_max_m").get<double>(), largest, 1e-9);
    EXPECT_EQ(level.at("triangles"), triangles);
  }
  // CGAL agrees: never beyond the vertical maximum but for its own error.
  EXPECT_GE(found.at("hausdorff").size(), 3U);
  for (const json& h : found.at("hausdorff")) {
    EXPECT_LE(h.at("hausdorff_m").get<double>(),
              h.at("vertical_max_m").get<double>() + h.at("error_bound_m").get<double>());
  }
}

TEST_F(AuditTest, PassesTreesWithHolesFractionsAndOneTile) {
  write_raster(dem_, {.columns = 50, .rows = 41}, holed_hills);
  for (const int tile_cells : {8, 16, 64}) {
    for (const int shift : {0, -3}) {
      for (const int levels : {1, 2}) {
        write_tree(path_, make_regular_tree(
                              dem_, {.tile_cells = tile_cells, .levels_per_doubling = levels, .xy_shift = shift}));
        const ProgramResult r = audit();
        EXPECT_EQ(r.exit_code, 0) << r.all();
      }
    }
  }
}

/// Surfaces that lie parallel, or upon each other, are the worst case of CGAL's subdivision.
TEST_F(AuditTest, CgalCopesWithFlatGround) {
  for (const double height : {10.0, 10.4}) {
    write_raster(dem_, {.columns = 260, .rows = 260, .dx = 30, .dy = 30}, [height](int, int) { return height; });
    write_tree(path_, make_regular_tree(dem_, {.tile_cells = 64, .leaf_error_m = 15, .z_step_m = 1}));
    const std::string report = dir_.file("report.json");
    const ProgramResult r = audit({"--json", report});
    EXPECT_EQ(r.exit_code, 0) << r.all();
    const json found = json::parse(read_file(report));
    EXPECT_EQ(found.at("hausdorff").size(), 10U);
    EXPECT_LT(found.at("seconds").get<double>(), 60);
  }
}

TEST_F(AuditTest, PassesATreeThatLacksEmptyTiles) {
  write_raster(dem_, {.columns = 50, .rows = 41},
               [](int c, int r) { return c > 14 && r < 34 ? kMissing : hills(c, r); });
  tree_ = make_regular_tree(dem_, {.tile_cells = 8});
  std::size_t whole = 0;
  for (int level = 0; level <= tree_.manifest.layout.leaf_level; ++level) {
    whole += std::size_t{tree_.manifest.layout.tiles_x(level)} * tree_.manifest.layout.tiles_y(level);
  }
  ASSERT_LT(tree_.tiles.size(), whole);
  write_tree(path_, tree_);
  EXPECT_EQ(audit().exit_code, 0);
}

TEST_F(AuditTest, GivesTheSameReportWithOneThreadAndMany) {
  write_tree(path_, tree_);
  std::vector<json> found;
  for (const char* threads : {"1", "4"}) {
    const std::string report = dir_.file("report.json");
    EXPECT_EQ(audit({"--threads", threads, "--json", report}).exit_code, 0);
    json j = json::parse(read_file(report));
    for (const char* key : {"seconds", "samples_per_second", "peak_rss_bytes"}) j.erase(key);
    for (json& level : j.at("levels")) level.erase("seconds");
    found.push_back(j);
  }
  EXPECT_EQ(found[0], found[1]);
}

/// Every address of a picture or a style in the page must be within it.
void expect_self_contained(const std::string& page) {
  for (const char* outside : {"http://", "https://", "src=\"/", "<script", "<link"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST_F(AuditTest, WritesAPage) {
  write_tree(path_, tree_);
  const std::string folder = dir_.file("new/folder");
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--report", folder}).exit_code, 0);
  const std::string page = read_file(folder + "/index.html");
  EXPECT_NE(page.find("Pass</strong>"), std::string::npos);
  expect_self_contained(page);
  // The terrain, three maps, and three pictures of each of the ten worst tiles.
  EXPECT_EQ(count_of(page, "data:image/png;base64,"), 1U + 3 + 3 * 10);
  EXPECT_EQ(count_of(page, "class=\"histogram\""), 3U);
  EXPECT_EQ(count_of(page, "holds</td>"), 9U);
  EXPECT_NE(page.find(tree_.manifest.samples_digest), std::string::npos);
}

#ifdef TINTREE_AUDIT_DRAWS
TEST_F(AuditTest, ComparesPictures) {
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  const ProgramResult r = audit({"--hausdorff-tiles", "0", "--images", "--json", report, "--report", dir_.path()});
  EXPECT_EQ(r.exit_code, 0) << r.all();
  const json found = json::parse(read_file(report));
  ASSERT_EQ(found.at("views").size(), 12U);
  for (const json& view : found.at("views")) {
    EXPECT_EQ(view.at("crack_px"), 0);
    EXPECT_LE(view.at("shift_max_px").get<double>(), view.at("limit_px").get<double>());
  }
  const std::string page = read_file(dir_.file("index.html"));
  expect_self_contained(page);
  EXPECT_EQ(count_of(page, "data:image/png;base64,"), 1U + 3 + 3 * 10 + 2 * 4);
}
#endif

TEST_F(AuditTest, ThePageOfABadTreeNamesItsTile) {
  const codec::TileId id{2, 1, 1};
  raise_vertex(id, 1.01 * tree_.manifest.layout.bound_m(2) + tree_.tile(id).info.error_m);
  write_tree(path_, tree_);
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--report", dir_.path()}).exit_code, 1);
  const std::string page = read_file(dir_.file("index.html"));
  EXPECT_NE(page.find("Fail</strong>"), std::string::npos);
  expect_self_contained(page);
  EXPECT_NE(page.find("tile&nbsp;2/1/1"), std::string::npos);
  EXPECT_LT(page.find("<h3>Tile 2/1/1"), page.find("<h3>Tile", page.find("<h3>Tile") + 1)) << "the worst comes first";
}

TEST_F(AuditTest, SaysWhenThePageCannotBeWritten) {
  write_tree(path_, tree_);
  write_file(dir_.file("in_the_way"), "");
  const ProgramResult r = audit({"--hausdorff-tiles", "0", "--report", dir_.file("in_the_way")});
  EXPECT_EQ(r.exit_code, 4) << r.all();
  EXPECT_NE(r.err.find("in_the_way"), std::string::npos) << r.err;
  EXPECT_EQ(r.out, "") << "before the work";
}

TEST_F(AuditTest, FindsAVertexMovedBeyondTheBound) {
  const codec::TileId id{2, 1, 1};
  raise_vertex(id, 1.01 * tree_.manifest.layout.bound_m(2) + tree_.tile(id).info.error_m);
  expect_found(id, "bound");
  // Even if the tile owns up to it.
  measure_again(id);
  expect_found(id, "bound");
}

TEST_F(AuditTest, FindsAWrongStoredError) {
  const codec::TileId id{1, 0, 1};
  for (double cache::TileInfo::*figure : {&cache::TileInfo::error_m, &cache::TileInfo::border_error_m,
                                          &cache::TileInfo::rms_m, &cache::TileInfo::z_min_m}) {
    const cache::TileInfo before = tree_.tile(id).info;
    tree_.tile(id).info.*figure -= 0.01;
    expect_found(id, "stored_figure");
    tree_.tile(id).info = before;
  }
  ++tree_.tile(id).info.triangles;
  expect_found(id, "stored_figure");
}

TEST_F(AuditTest, FindsABoxThatDoesNotHoldItsTile) {
  const codec::TileId id{2, 1, 0};
  write_tree(path_, tree_);
  expect_bounds_found({id, 0, static_cast<float>(tree_.tile(id).info.z_min_m + 0.5)}, id, "hierarchy");
  // Understating the error would let a viewer take the tile from too near.
  write_tree(path_, tree_);
  expect_bounds_found({id, 8, static_cast<float>(tree_.tile(id).info.error_m / 2)}, id, "hierarchy");
}

TEST_F(AuditTest, FindsABoxThatReachesOutOfItsParents) {
  const codec::TileId id{2, 2, 2};
  write_tree(path_, tree_);
  expect_bounds_found({id, 4, 1e5F}, id, "hierarchy");
}

TEST_F(AuditTest, FindsARowThatIsNoTile) {
  write_tree(path_, tree_);
  change_file(
      "INSERT INTO tile SELECT key + 77, vertices, triangles, z_min_m, z_max_m, error_m, rms_m, border_error_m,"
      " checksum, payload FROM tile WHERE key = 0");
  expect_file_found("file");
}

TEST_F(AuditTest, FindsAnotherDigestThanTheManifests) {
  tree_.manifest.samples_digest = "00112233445566778899aabbccddeeff";
  write_tree(path_, tree_);
  expect_file_found("manifest");
}

/// Heights that differ by less than any tolerance are other heights all the same.
TEST_F(AuditTest, FindsThatTheDemIsNotTheOneGiven) {
  write_tree(path_, tree_);
  write_raster(dem_, {.columns = 50, .rows = 41, .dx = 10, .dy = 10},
               [](int c, int r) { return hills(c, r) + (c == 7 && r == 9 ? 1e-5 : 0); });
  expect_file_found("manifest");
}

/// Leaves and their parents that drift apart along their common lines, each true to its own figures.
TEST_F(AuditTest, FindsAGapBetweenLevels) {
  tree_ = make_regular_tree(dem_, {.tile_cells = 16, .leaf_error_m = 50});
  for (cache::StoredTile& tile : tree_.tiles) {
    if (tile.info.id.level != 1) continue;
    codec::TileMesh mesh = tree_.mesh(tile.info.id);
    mesh.z_offset += static_cast<std::int64_t>(10 / tree_.manifest.layout.z_step_m[1]);
    tree_.set_mesh(tile.info.id, mesh);
    measure_again(tile.info.id);
    tile.info.border_error_m = tile.info.error_m = 1;
  }
  expect_found({2, 2, 1}, "gap");
}

/// Likewise where both levels lie on the same squares.
TEST_F(AuditTest, FindsAGapBetweenLevelsOfEqualTiles) {
  tree_ = make_regular_tree(dem_, {.tile_cells = 16, .levels_per_doubling = 2, .leaf_error_m = 50});
  write_tree(path_, tree_);
  EXPECT_EQ(audit().exit_code, 0);
  codec::TileMesh mesh = tree_.mesh({1, 0, 0});
  mesh.z_offset += static_cast<std::int64_t>(10 / tree_.manifest.layout.z_step_m[1]);
  tree_.set_mesh({1, 0, 0}, mesh);
  for (cache::StoredTile& tile : tree_.tiles) tile.info.border_error_m = tile.info.error_m = 1;
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--json", report}).exit_code, 1);
  const json list = json::parse(read_file(report)).at("violation_list");
  for (const std::string fine : {"2/1/0", "2/0/1"}) {
    EXPECT_TRUE(std::ranges::any_of(list,
                                    [&](const json& v) {
                                      return v.at("kind") == "gap" && v.at("tile") == fine &&
                                             v.at("message").get<std::string>().find("from tile 1/0/0 ") !=
                                                 std::string::npos;
                                    }))
        << fine << " not in " << list.dump(1);
  }
}

TEST_F(AuditTest, MeasuresTheGapBetweenLevels) {
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--json", report}).exit_code, 0);
  const json found = json::parse(read_file(report));
  EXPECT_EQ(found.at("levels")[0].at("gap_max_m"), 0);
  EXPECT_EQ(found.at("levels")[1].at("gap_max_m"), 0) << "the root has no neighbour";
  EXPECT_NEAR(found.at("levels")[2].at("gap_max_m").get<double>(), leaf_gap(), 1e-9);
  EXPECT_GT(leaf_gap(), 0.1);
  EXPECT_LE(found.at("levels")[2].at("gap_max_px").get<double>(), 1);
}

TEST_F(AuditTest, MeasuresTheQuantileOfTheErrors) {
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--json", report}).exit_code, 0);
  const json found = json::parse(read_file(report));
  for (int level = 0; level <= 2; ++level) {
    std::vector<double> errors = sample_errors(level);
    std::ranges::sort(errors);
    const double exact = errors[static_cast<std::size_t>(std::ceil(0.999 * static_cast<double>(errors.size()))) - 1];
    const double bin = tree_.manifest.layout.bound_m(level) / 2048;
    const auto given = found.at("levels")[static_cast<std::size_t>(level)].at("vertical_p999_m").get<double>();
    EXPECT_GE(given, exact - 1e-9);
    EXPECT_LE(given, exact + bin + 1e-9);
  }
}

TEST_F(AuditTest, FindsADroppedTriangle) {
  const codec::TileId id{2, 0, 2};
  codec::TileMesh mesh = tree_.mesh(id);
  mesh.triangles.erase(mesh.triangles.begin() + 77);
  tree_.set_mesh(id, mesh);
  measure_again(id);
  expect_found(id, "coverage");
}

TEST_F(AuditTest, FindsAShiftedBorderVertex) {
  tree_ = make_regular_tree(dem_, {.tile_cells = 16, .leaf_error_m = 50});
  const codec::TileId id{2, 1, 1};
  codec::TileMesh mesh = tree_.mesh(id);
  const auto at = std::ranges::find_if(mesh.vertices, [](const codec::GridVertex& v) { return v.x == 0 && v.y == 5; });
  ASSERT_NE(at, mesh.vertices.end());
  ++at->z;
  tree_.set_mesh(id, mesh);
  measure_again(id);
  expect_found(id, "border");
}

TEST_F(AuditTest, FindsAFlippedByteInAPayload) {
  write_tree(path_, tree_);
  const codec::TileId id{1, 1, 0};
  std::string file = read_file(path_);
  const auto& payload = tree_.tile(id).payload;
  // Where the payload lies contiguously: its first bytes may be on another page.
  const std::string tail(reinterpret_cast<const char*>(payload.data()) + payload.size() - 40, 40);
  const std::size_t at = file.find(tail);
  ASSERT_NE(at, std::string::npos);
  file[at + 20] = static_cast<char>(file[at + 20] ^ 0x10);
  write_file(path_, file);
  expect_found_in_file(id, "file");
}

TEST_F(AuditTest, FindsAMissingTile) {
  const codec::TileId id{2, 3, 1};
  // Left out from the start.
  TestTree whole = tree_;
  std::erase_if(tree_.tiles, [&](const cache::StoredTile& t) { return t.info.id == id; });
  expect_found(id, "missing_tile");
  // Removed from the file afterwards.
  write_tree(path_, whole);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
  const std::string sql = "DELETE FROM tile WHERE key = " + std::to_string(id.key());
  ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  expect_found_in_file(id, "file");
}

TEST_F(AuditTest, FindsATileWhereTheDemHasNoSurface) {
  // The tree is of a DEM that had surface everywhere.
  write_raster(dem_, {.columns = 50, .rows = 41, .dx = 10, .dy = 10},
               [](int c, int r) { return c > 31 ? kMissing : hills(c, r); });
  write_tree(path_, tree_);
  const std::string report = dir_.file("report.json");
  EXPECT_EQ(audit({"--hausdorff-tiles", "0", "--json", report}).exit_code, 1);
  EXPECT_NE(read_file(report).find("extra_tile"), std::string::npos);
}

TEST_F(AuditTest, RefusesAnotherDem) {
  write_tree(path_, tree_);
  const auto expect_refused = [this](const RasterSpec& spec, const std::string& what) {
    write_raster(dem_, spec, [](int c, int r) { return hills(c, r); });
    const ProgramResult refused = audit();
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.err.find(what), std::string::npos) << refused.err;
    EXPECT_EQ(refused.out, "");
  };
  expect_refused({.columns = 51, .rows = 41, .dx = 10, .dy = 10}, "51 x 41");
  expect_refused({.columns = 50, .rows = 41, .dx = 20, .dy = 10}, "20 x 10 m");
}

TEST_F(AuditTest, RefusesFilesItCannotUse) {
  EXPECT_EQ(audit().exit_code, 4);  // no tree
  write_file(path_, "this is no tree at all, but long enough to look at");
  EXPECT_EQ(audit().exit_code, 3);
  write_tree(path_, tree_);
  const std::string whole = read_file(path_);
  write_file(path_, whole.substr(0, whole.size() / 2 - 7));
  const ProgramResult cut = audit();
  EXPECT_EQ(cut.exit_code, 3) << cut.all();
  EXPECT_NE(cut.err.find(path_), std::string::npos) << cut.err;
  write_file(path_, whole);
  EXPECT_EQ(run_program(TINTREE_AUDIT, {path_, "--dem", dir_.file("nowhere.tif")}).exit_code, 4);
  EXPECT_EQ(run_program(TINTREE_AUDIT, {path_, "--dem", path_}).exit_code, 3);
}

TEST_F(AuditTest, RefusesANewerFormat) {
  write_tree(path_, tree_);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(db, "PRAGMA user_version = 3", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  const ProgramResult r = audit();
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_NE(r.err.find("newer"), std::string::npos) << r.err;
}

TEST_F(AuditTest, RefusesUnknownOptions) {
  EXPECT_EQ(audit({"--sideways"}).exit_code, 2);
  EXPECT_EQ(audit({"--threads", "-1"}).exit_code, 2);
  EXPECT_EQ(run_program(TINTREE_AUDIT, {path_}).exit_code, 2);
}

TEST_F(AuditTest, SaysWhenTheReportCannotBeWritten) {
  write_tree(path_, tree_);
  const ProgramResult r = audit({"--hausdorff-tiles", "0", "--json", dir_.file("no/such/folder.json")});
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_EQ(r.out, "") << "before the work";
  EXPECT_NE(r.err.find("folder.json"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace tintree::test
