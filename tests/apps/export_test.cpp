/// Exported files, read back by OpenMesh and by a few lines of their own, against the DEM itself.

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <gtest/gtest.h>

#include "tests/support/naive_measure.h"
#include "tests/support/regular_tree.h"
#include "tests/support/run_program.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::test {
namespace {

/// A triangle mesh as a foreign program would read it.
struct Soup {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::string comments;
};

Soup read_obj(const std::string& path) {
  Soup soup;
  std::istringstream in(read_file(path));
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "#") soup.comments += line + "\n";
    if (kind == "v") {
      auto& p = soup.vertices.emplace_back();
      words >> p[0] >> p[1] >> p[2];
    }
    if (kind == "f") {
      auto& f = soup.faces.emplace_back();
      words >> f[0] >> f[1] >> f[2];
      for (std::uint32_t& v : f) --v;
    }
  }
  return soup;
}

Soup read_ply(const std::string& path) {
  Soup soup;
  const std::string file = read_file(path);
  std::istringstream in(file);
  std::string line;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  while (std::getline(in, line) && line != "end_header") {
    if (line.starts_with("comment")) soup.comments += line + "\n";
    if (line.starts_with("element vertex ")) vertices = std::stoul(line.substr(15));
    if (line.starts_with("element face ")) faces = std::stoul(line.substr(13));
  }
  const char* at = file.data() + in.tellg();
  EXPECT_EQ(file.size() - static_cast<std::size_t>(in.tellg()), vertices * 24 + faces * 13);
  soup.vertices.resize(vertices);
  std::memcpy(soup.vertices.data(), at, vertices * 24);
  at += vertices * 24;
  for (std::size_t i = 0; i < faces; ++i, at += 13) {
    EXPECT_EQ(*at, 3);
    std::memcpy(soup.faces.emplace_back().data(), at + 1, 12);
  }
  return soup;
}

/// How many edges have one triangle; fails on edges of more than two, or run twice the same way.
std::size_t open_edges(const Soup& soup) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const auto& f : soup.faces) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(++uses[std::pair(f[k], f[(k + 1) % 3])], 1);
  }
  std::size_t open = 0;
  for (const auto& [edge, count] : uses) open += uses.contains({edge.second, edge.first}) ? 0U : 1U;
  return open;
}

/// Largest vertical distance at the samples; every sample of a whole DEM must be covered.
double sample_error(const Soup& soup, const HeightGrid& grid, double dx, double dy, bool all_covered = true) {
  std::vector<double> mesh(grid.heights_m.size(), kMissing);
  for (const auto& f : soup.faces) {
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& v = soup.vertices.at(f[k]);
      p[k] = {v[0] / dx, -v[1] / dy, v[2]};
    }
    const auto [c0, c1] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [r0, r1] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (double r = std::ceil(r0 - 1e-9); r <= r1 + 1e-9; ++r) {
      for (double c = std::ceil(c0 - 1e-9); c <= c1 + 1e-9; ++c) {
        bool inside = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const auto& a = p[k];
          const auto& b = p[(k + 1) % 3];
          inside = inside && (c - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (r - a[1]) > -1e-9;
        }
        if (inside)
          mesh[static_cast<std::size_t>(r) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(c)] =
              plane_height(p, c, r);
      }
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    if (std::isnan(mesh[i])) {
      EXPECT_FALSE(all_covered) << i;
      continue;
    }
    largest = std::max(largest, std::abs(mesh[i] - grid.heights_m[i]));
  }
  return largest;
}

class ExportTest : public testing::Test {
 protected:
  ExportTest() : dem_(dir_.file("dem.tif")), path_(dir_.file("tree.tintree")) {
    // Flat in the west, so that a cut has tiles of several levels.
    make([](int c, int r) { return c < 30 ? 0.3 * hills(c, r) : hills(c, r); }, {.tile_cells = 8});
  }

  void make(const HeightFunction& height, const RegularTreeOptions& options) {
    write_raster(dem_, {.columns = 50, .rows = 41, .dx = 30, .dy = 20, .west = 500000, .north = 4000000}, height);
    tree_ = make_regular_tree(dem_, options);
    write_tree(path_, tree_);
  }

  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), path_);
    return run_program(TINTREE_EXPORT, arguments);
  }

  Soup export_as(const std::string& format, const std::vector<std::string>& what) const {
    const std::string out = dir_.file("mesh." + format);
    std::vector<std::string> arguments{"--to", format, "-o", out, "--overwrite"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    const ProgramResult r = run(arguments);
    EXPECT_EQ(r.exit_code, 0) << r.all();
    EXPECT_FALSE(std::filesystem::exists(out + ".tmp"));
    EXPECT_FALSE(std::filesystem::exists(out + ".faces.tmp"));
    return format == "ply" ? read_ply(out) : read_obj(out);
  }

  TempDir dir_;
  std::string dem_;
  std::string path_;
  TestTree tree_;
};

TEST_F(ExportTest, EveryLevelIsOneWatertightMeshWithinItsBound) {
  const HeightGrid grid = read_grid(dem_);
  for (int level = 0; level <= tree_.manifest.layout.leaf_level; ++level) {
    for (const char* format : {"ply", "obj"}) {
      const Soup soup = export_as(format, {"--level", std::to_string(level)});
      EXPECT_LE(sample_error(soup, grid, 30, 20), tree_.manifest.layout.bound_m(level) * (1 + 1e-9));
      // The outline is all that is open: as many edges as there are stations around the raster.
      const std::int64_t stride = std::int64_t{1} << (tree_.manifest.layout.leaf_level - level);
      const auto stations = [stride](std::int64_t cells) {
        return static_cast<std::size_t>((cells + stride - 1) / stride);
      };
      EXPECT_EQ(open_edges(soup), 2 * (stations(49) + stations(40))) << format << " " << level;
    }
  }
}

TEST_F(ExportTest, PlyAndObjHoldTheSameNumbers) {
  const Soup ply = export_as("ply", {"--level", "2"});
  const Soup obj = export_as("obj", {"--level", "2"});
  EXPECT_EQ(ply.vertices, obj.vertices);
  EXPECT_EQ(ply.faces, obj.faces);
}

TEST_F(ExportTest, OpenMeshReadsBothAsOneManifold) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  for (const char* format : {"ply", "obj"}) {
    const Soup soup = export_as(format, {"--level", "1"});
    Mesh mesh;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(mesh, dir_.file(std::string("mesh.") + format)));
    EXPECT_EQ(mesh.n_vertices(), soup.vertices.size());
    EXPECT_EQ(mesh.n_faces(), soup.faces.size());
    std::size_t open = 0;
    for (const auto edge : mesh.edges()) open += mesh.is_boundary(edge) ? 1U : 0U;
    EXPECT_EQ(open, open_edges(soup));
    // An open disk: V - E + F = 1.
    EXPECT_EQ(mesh.n_vertices() + mesh.n_faces(), mesh.n_edges() + 1);
    for (const auto v : mesh.vertices()) EXPECT_TRUE(mesh.is_manifold(v));
  }
}

TEST_F(ExportTest, HolesStayOpenAndNeighboursStayJoined) {
  const auto hole = [](int c, int r) {
    return (c > 13 && c < 19 && r > 3 && r < 21) || (c == 24 && r == 24) || (c == 40 && r == 16);
  };
  make([&](int c, int r) { return hole(c, r) ? kMissing : hills(c, r); }, {.tile_cells = 8, .xy_shift = -2});
  const HeightGrid grid = read_grid(dem_);
  std::size_t outline = 2 * (49 + 40);
  std::size_t triangles = 0;
  for (int r = 0; r < 40; ++r) {
    for (int c = 0; c < 49; ++c) triangles += (grid.has_lower(c, r) ? 1U : 0U) + (grid.has_upper(c, r) ? 1U : 0U);
  }
  // Missing samples each open a hexagon; the block one of its size: rows, columns and two diagonals.
  outline += 6 + 6 + 2 * (5 + 17 + 1);
  for (int level = 0; level <= tree_.manifest.layout.leaf_level; ++level) {
    const Soup soup = export_as("ply", {"--level", std::to_string(level)});
    EXPECT_EQ(soup.faces.size(), triangles);
    EXPECT_EQ(open_edges(soup), outline) << level;
    EXPECT_LE(sample_error(soup, grid, 30, 20, false), tree_.manifest.layout.bound_m(level) * (1 + 1e-9));
  }
}

TEST_F(ExportTest, ACutKeepsItsErrorWithTheCoarsestTiles) {
  const HeightGrid grid = read_grid(dem_);
  double previous = 1e9;
  for (const double share : {0.25, 1.0, 2.5}) {
    const double error = share * tree_.manifest.layout.bound_m(tree_.manifest.layout.leaf_level) * 2;
    const ProgramResult r =
        run({"--to", "ply", "-o", dir_.file("probe.ply"), "--error", std::to_string(error), "--overwrite"});
    if (r.exit_code == 2) continue;  // finer than the leaves
    const Soup soup = export_as("ply", {"--error", std::to_string(error)});
    EXPECT_LE(sample_error(soup, grid, 30, 20), error * (1 + 1e-6));
    EXPECT_LT(static_cast<double>(soup.faces.size()), previous);
    previous = static_cast<double>(soup.faces.size());
  }
  EXPECT_LT(previous, 1e9);
  // A large error is the root alone.
  EXPECT_EQ(export_as("ply", {"--error", "1e6"}).faces, export_as("ply", {"--level", "0"}).faces);
}

TEST_F(ExportTest, NamesTheSmallestErrorThatWorks) {
  const ProgramResult r = run({"--to", "ply", "-o", dir_.file("x.ply"), "--error", "1e-9"});
  EXPECT_EQ(r.exit_code, 2);
  const std::size_t at = r.err.find("give is ");
  ASSERT_NE(at, std::string::npos) << r.err;
  std::istringstream words(r.err.substr(at + 8));
  std::string smallest;
  words >> smallest;
  EXPECT_EQ(run({"--to", "ply", "-o", dir_.file("x.ply"), "--error", smallest}).exit_code, 0) << smallest;
}

TEST_F(ExportTest, StatesTheOriginAndTheCrs) {
  for (const char* format : {"ply", "obj"}) {
    const Soup soup = export_as(format, {"--level", "0"});
    EXPECT_NE(soup.comments.find("500015 3999990"), std::string::npos) << soup.comments;
    EXPECT_NE(soup.comments.find("UTM zone 10N"), std::string::npos) << soup.comments;
    EXPECT_NE(soup.comments.find("metres"), std::string::npos) << soup.comments;
  }
}

TEST_F(ExportTest, RefusesWhatMakesNoSense) {
  const std::string out = dir_.file("mesh.ply");
  EXPECT_EQ(run({"--to", "ply", "-o", out}).exit_code, 2);
  EXPECT_EQ(run({"--to", "ply", "-o", out, "--level", "0", "--error", "1"}).exit_code, 2);
  EXPECT_EQ(run({"--to", "glb", "-o", out, "--level", "0"}).exit_code, 2);
  EXPECT_EQ(run({"--to", "ply", "-o", out, "--error", "-1"}).exit_code, 2);
  EXPECT_EQ(run({"--to", "ply", "-o", out, "--error", "nan"}).exit_code, 2);
  EXPECT_EQ(run({"--to", "ply", "-o", out, "--level", "0", "--sideways"}).exit_code, 2);
  for (const char* level : {"-1", "9"}) {
    const ProgramResult r = run({"--to", "ply", "-o", out, "--level", level});
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_NE(r.err.find("levels 0 to 3"), std::string::npos) << r.err;
  }
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(ExportTest, KeepsWhatExists) {
  const std::string out = dir_.file("mesh.obj");
  write_file(out, "mine");
  const ProgramResult r = run({"--to", "obj", "-o", out, "--level", "0"});
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_NE(r.err.find("--overwrite"), std::string::npos) << r.err;
  EXPECT_EQ(read_file(out), "mine");
  EXPECT_EQ(run({"--to", "obj", "-o", out, "--level", "0", "--overwrite"}).exit_code, 0);
  EXPECT_NE(read_file(out), "mine");
  EXPECT_EQ(run({"--to", "obj", "-o", path_, "--level", "0", "--overwrite"}).exit_code, 2);
}

TEST_F(ExportTest, LeavesNothingBehindWhenItFails) {
  // A tile in the middle is damaged.
  std::string file = read_file(path_);
  const auto& payload = tree_.tiles.back().payload;
  const std::size_t at =
      file.find(std::string(reinterpret_cast<const char*>(payload.data()) + payload.size() - 30, 30));
  ASSERT_NE(at, std::string::npos);
  file[at + 10] = static_cast<char>(file[at + 10] ^ 1);
  write_file(path_, file);
  const ProgramResult r = run({"--to", "ply", "-o", dir_.file("mesh.ply"), "--level", "3"});
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_NE(r.err.find("tile " + tree_.tiles.back().info.id.text()), std::string::npos) << r.err;
  EXPECT_EQ(run({"--to", "ply", "-o", dir_.file("no/such/mesh.ply"), "--level", "0"}).exit_code, 4);
  EXPECT_EQ(run({"--to", "ply", "-o", dir_.path(), "--level", "0"}).exit_code, 4);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(dir_.path())) ++files;
  EXPECT_EQ(files, 2U);
}

TEST_F(ExportTest, SaysWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  std::filesystem::create_symlink("/dev/full", dir_.file("mesh.obj.tmp"));
  const ProgramResult r = run({"--to", "obj", "-o", dir_.file("mesh.obj"), "--level", "3"});
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_NE(r.err.find("No space left"), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(dir_.file("mesh.obj")));
}

TEST_F(ExportTest, RefusesFilesItCannotUse) {
  std::filesystem::remove(path_);
  EXPECT_EQ(run({"--to", "ply", "-o", dir_.file("mesh.ply"), "--level", "0"}).exit_code, 4);
  write_file(path_, "not a tree");
  EXPECT_EQ(run({"--to", "ply", "-o", dir_.file("mesh.ply"), "--level", "0"}).exit_code, 3);
}

}  // namespace
}  // namespace tintree::test
