#include <cmath>
#include <cstdio>
#include <string>

#include <malloc.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/build/build_tree.h"
#include "apps/build/plan.h"
#include "apps/build/summary.h"
#include "apps/common/json_file.h"
#include "apps/common/program.h"
#include "apps/common/whole_file.h"
#include "codec/mesh_codec.h"
#include "simplify/tile_maker.h"

namespace {

using tintree::ErrorCode;
using tintree::Expected;
using tintree::app::BuildOptions;

Expected<void> check(const BuildOptions& o) {
  const bool power_of_two = o.tile_cells > 0 && (o.tile_cells & (o.tile_cells - 1)) == 0;
  if (!power_of_two || o.tile_cells < 8 || o.tile_cells > 4096) {
    return tintree::fail(ErrorCode::kUsage, "must be a power of two from 8 to 4096", "--tile");
  }
  if (o.texture_size) {
    const int size = *o.texture_size;
    if (size < 16 || size > 4096 || (size & (size - 1)) != 0)
      return tintree::fail(ErrorCode::kUsage, "must be a power of two from 16 to 4096", "--texture-size");
    if (o.orthos.empty())
      return tintree::fail(ErrorCode::kUsage, "has no effect without --ortho; name a photo", "--texture-size");
  }
  if (o.texture_depth) {
    if (*o.texture_depth < 0 || *o.texture_depth > tintree::cache::kMostTextureDepth) {
      return tintree::fail(ErrorCode::kUsage, fmt::format("must be from 0 to {}", tintree::cache::kMostTextureDepth),
                           "--texture-depth");
    }
    if (o.orthos.empty())
      return tintree::fail(ErrorCode::kUsage, "has no effect without --ortho; name a photo", "--texture-depth");
  }
  if (o.error_m && !(std::isfinite(*o.error_m) && *o.error_m > 0)) {
    return tintree::fail(ErrorCode::kUsage, "must be a positive number of metres", "--error");
  }
  if (o.quantizer && o.method != "scalar")
    return tintree::fail(ErrorCode::kUsage, "is for --method scalar; leave it out with " + o.method, "--quantizer");
  if (o.criterion && o.method != "wavelet")
    return tintree::fail(ErrorCode::kUsage, "is for --method wavelet; leave it out with " + o.method, "--criterion");
  if (o.effort == "best" && o.method != "tin" && o.method != "strip")
    return tintree::fail(ErrorCode::kUsage, "best is for --method tin and strip; leave it out with " + o.method,
                         "--effort");
  if (o.levels_per_doubling > tintree::codec::most_levels_per_doubling(o.method)) {
    return tintree::fail(ErrorCode::kUsage,
                         "is 1 for --method " + o.method + "; leave it out, or choose --method tin, strip or scalar",
                         "--levels-per-doubling");
  }
  if (o.threads < 0 || o.threads > 1024)
    return tintree::fail(ErrorCode::kUsage, "must lie between 0 (all cores) and 1024", "--threads");
  if (o.output.empty() && !o.plan) return tintree::fail(ErrorCode::kUsage, "is required (see --help)", "--output");
  if (o.resume && o.overwrite)
    return tintree::fail(ErrorCode::kUsage, "choose one of --resume and --overwrite", "--resume");
  return {};
}

Expected<void> plan(const BuildOptions& o) {
  const auto plan = tintree::app::plan_tree(o);
  if (!plan) return tl::unexpected(plan.error());
  if (!o.quiet) fmt::print("{}", tintree::app::plan_text(*plan));
  return o.json.empty() ? Expected<void>{} : tintree::app::write_json(o.json, tintree::app::plan_json(*plan, o));
}

/// Has large buffers, made on one thread and dropped on another, go back to the system at once. Without this the
/// C library keeps room for as many as each thread ever had, beyond --memory.
void give_back_large_memory() { ::mallopt(M_MMAP_THRESHOLD, 256 * 1024); }

}  // namespace

int main(int argc, char** argv) {
  give_back_large_memory();
  tintree::app::stop_flag();  // from the first moment on
  BuildOptions o;
  std::string nodata = "hole";
  CLI::App app{"Builds a tile tree with a guaranteed, measured error from an elevation model", "tintree-build"};
  app.add_option("DEM", o.dems, "Elevation models on one grid, any rasters that GDAL reads; the last lies on top")
      ->required();
  app.add_option("-o,--output", o.output, "Tree to write (.tintree); required, except with --plan");
  app.add_option(
      "--error", o.error_m,
      "Error bound of the leaves in metres; doubles from level to level up (default: half the sample spacing)");
  app.add_option("--method", o.method, "How tiles are made")
      ->check(CLI::IsMember(tintree::simplify::method_names()))
      ->capture_default_str();
  app.add_option("--effort", o.effort,
                 "fast, or with --method tin and strip best, for fewer triangles and bytes in a multiple of the time")
      ->check(CLI::IsMember({"fast", "best"}))
      ->capture_default_str();
  app.add_option("--quantizer", o.quantizer, "With --method scalar: how heights are quantised (default: uniform)")
      ->check(CLI::IsMember({"uniform", "lloyd-max"}));
  app.add_option("--criterion", o.criterion,
                 "With --method wavelet, what the coded heights of a tile keep within its bound beside the surface: "
                 "max each, or rms their root mean square (default)")
      ->check(CLI::IsMember({"max", "rms"}));
  app.add_option("--tile", o.tile_cells, "DEM cells along a leaf's side, a power of two")->capture_default_str();
  app.add_option("--levels-per-doubling", o.levels_per_doubling,
                 "2: a level between each two, errors a factor of √2 apart, so that fewer triangles are drawn from a "
                 "larger file")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  app.add_option("--ortho", o.orthos,
                 "Photos to drape over the terrain, in any format and CRS that GDAL reads; the last lies on top");
  app.add_option(
      "--texture-size", o.texture_size,
      "Texels along a tile's side, a power of two (default: 256, or 512 or 1024 where the photos are finer)");
  app.add_option("--texture-depth", o.texture_depth,
                 "How often leaves are halved, at most, for textures as fine as the photos (default: 5)");
  app.add_option("--texture-codec", o.texture_codec,
                 "bc1 is drawn as it is stored, jpeg takes less of the disk and more of the card")
      ->check(CLI::IsMember({"bc1", "jpeg"}))
      ->capture_default_str();
  app.add_flag("--normal-maps", o.normal_maps, "Store normal maps, so that coarse tiles are lit like fine ones");
  app.add_option("--threads", o.threads, "Threads to use, 0 for all cores")->capture_default_str();
  app.add_option("--memory", o.memory_mib, "Memory to stay within, MiB")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--nodata", nodata, "Samples without a height: hole leaves them out, fill interpolates them")
      ->check(CLI::IsMember({"hole", "fill"}))
      ->capture_default_str();
  app.add_flag("--resume", o.resume, "Go on with a build that was stopped");
  app.add_flag("--overwrite", o.overwrite, "Replace an existing tree or discard an unfinished one");
  app.add_flag("--plan", o.plan,
               "Tell levels, tiles, bytes, time and memory from a sample of tiles, and write nothing");
  app.add_option("--json", o.json, "Write the figures to this file too");
  app.add_flag("--quiet", o.quiet, "No progress, warnings or table");
  return tintree::app::run_program(app, argc, argv, [&]() -> Expected<void> {
    using tintree::cache::NodataPolicy;
    o.nodata = nodata == "fill" ? NodataPolicy::kFill : NodataPolicy::kHole;
    if (auto sane = check(o); !sane) return sane;
    for (const auto* inputs : {&o.dems, &o.orthos}) {
      if (o.json.empty()) break;
      if (auto writable = tintree::app::check_output_file(o.json, *inputs); !writable) return writable;
    }
    if (o.plan) return plan(o);
    auto report = tintree::app::build_tree(o);
    if (!report) return tl::unexpected(report.error());
    if (!o.quiet) fmt::print("{}", tintree::app::summary_text(*report, o.output));
    return o.json.empty() ? Expected<void>{} : tintree::app::write_json(o.json, tintree::app::summary_json(*report));
  });
}
