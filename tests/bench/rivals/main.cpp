/// bench_rivals: other people's simplifiers and coders over one window, and the meter for all of them.
/// Heights are a file of 64-bit floats, NaN for none, meshes are PLY; figures are printed as one line of JSON.

#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/program.h"
#include "tests/bench/rivals/coded_size.h"
#include "tests/bench/rivals/mesh_error.h"
#include "tests/bench/rivals/simplifiers.h"

namespace {

using namespace tintree::bench;
using tintree::Expected;

struct Options {
  std::string grid;
  HeightGrid shape;
  std::string method;
  std::string mesh;
  double error_m = 0;
  double height_step_m = 1;
  std::string map;
};

const std::map<std::string, Simplified (*)(const HeightGrid&, double)> kSimplifiers{
    {"meshoptimizer", meshoptimizer}, {"openmesh", openmesh}, {"lindstrom-turk", lindstrom_turk}};

Expected<nlohmann::json> simplify(const HeightGrid& grid, const Options& o) {
  if (full_mesh(grid).triangles.empty()) {
    return tintree::fail(tintree::ErrorCode::kBadData, "no three samples of a cell are there: nothing to start from",
                         o.grid);
  }
  const Simplified made = kSimplifiers.at(o.method)(grid, o.error_m);
  if (auto written = write_ply(o.mesh, made.mesh); !written) return tl::unexpected(written.error());
  return nlohmann::json{{"seconds", made.seconds}};
}

Expected<void> write_map(const std::string& path, const std::vector<float>& map_m) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(map_m.data()), static_cast<std::streamsize>(map_m.size() * sizeof(float)));
  file.close();
  if (!file) return tintree::fail(tintree::ErrorCode::kIo, "cannot be written", path);
  return {};
}

Expected<nlohmann::json> measure_file(const HeightGrid& grid, const Options& o) {
  const auto mesh = read_ply(o.mesh);
  if (!mesh) return tl::unexpected(mesh.error());
  const MeshError error = measure(grid, *mesh);
  nlohmann::json out{{"triangles", mesh->triangles.size()},
                     {"vertices", mesh->vertices.size()},
                     {"samples_max_m", error.samples_max_m},
                     {"surface_max_m", error.surface_max_m},
                     {"rms_m", error.rms_m},
                     {"uncovered_samples", error.uncovered},
                     {"filled_samples", error.filled},
                     {"folded_triangles", error.folded}};
  if (!o.map.empty()) {
    if (auto written = write_map(o.map, error.map_m); !written) return tl::unexpected(written.error());
  }
  if (o.height_step_m > 0) {
    const auto coded = code_mesh(grid, *mesh, o.height_step_m);
    if (!coded) return tl::unexpected(coded.error());
    out["bytes"] = coded->bytes;
    out["decode_seconds"] = coded->decode_seconds;
  }
  return out;
}

Expected<nlohmann::json> code_jpegls(const HeightGrid& grid, const Options& o) {
  const auto coded = jpegls(grid, static_cast<int>(o.error_m));
  if (!coded) return tl::unexpected(coded.error());
  return nlohmann::json{{"bytes", coded->bytes},
                        {"samples_max_m", coded->max_error_m},
                        {"rms_m", coded->rms_m},
                        {"seconds", coded->seconds},
                        {"decode_seconds", coded->decode_seconds}};
}

using Command = Expected<nlohmann::json> (*)(const HeightGrid&, const Options&);

Expected<void> run(Command command, const Options& o) {
  const auto grid = read_grid(o.grid, o.shape);
  if (!grid) return tl::unexpected(grid.error());
  const auto figures = command(*grid, o);
  if (!figures) return tl::unexpected(figures.error());
  fmt::print("{}\n", figures->dump());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Other simplifiers and coders over one window of heights, and what their error really is",
               "bench_rivals"};
  Options o;
  app.add_option("GRID", o.grid, "Heights in metres, 64-bit floats, row by row from the north")->required();
  app.add_option("--columns", o.shape.columns)->required();
  app.add_option("--rows", o.shape.rows)->required();
  app.add_option("--dx", o.shape.dx_m, "Spacing eastward in metres");
  app.add_option("--dy", o.shape.dy_m, "Spacing southward in metres");
  app.require_subcommand(1);

  CLI::App* simplifier = app.add_subcommand("simplify", "Make a mesh");
  simplifier->add_option("METHOD", o.method)->required()->check(CLI::IsMember(&kSimplifiers));
  simplifier->add_option("ERROR", o.error_m, "Metres to ask for")->required();
  simplifier->add_option("MESH", o.mesh, "PLY file to write")->required();
  CLI::App* meter = app.add_subcommand("measure", "Measure a mesh and code it");
  meter->add_option("MESH", o.mesh)->required();
  meter->add_option("--height-step", o.height_step_m, "Heights are multiples of this many metres; 0: do not code");
  meter->add_option("--map", o.map, "File to write: for each sample the largest distance around it, 32-bit floats");
  CLI::App* coder = app.add_subcommand("jpegls", "Code the heights, near-lossless");
  coder->add_option("ERROR", o.error_m, "Metres, a whole number")->required();

  return tintree::app::run_program(app, argc, argv, [&] {
    if (app.got_subcommand(simplifier)) return run(simplify, o);
    return run(app.got_subcommand(meter) ? measure_file : code_jpegls, o);
  });
}
