/// tintree-export: one mesh file out of a tree.

#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/core.h>

#include "apps/common/program.h"
#include "apps/common/progress.h"
#include "apps/common/whole_file.h"
#include "apps/export/export_tree.h"

namespace {

using tintree::ErrorCode;
using tintree::Expected;
using tintree::fail;

struct Options {
  std::string tree;
  bool overwrite = false;
  bool quiet = false;
  tintree::exporter::ExportOptions mesh;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("TREE", o.tree, "The tree to export (.tintree)")->required();
  app.add_option("--to", o.mesh.format, "Format: ply (binary, doubles) or obj (text)")
      ->required()
      ->check(CLI::IsMember({"ply", "obj"}));
  app.add_option("-o,--output", o.mesh.path, "The file to write")->required();
  auto* what = app.add_option_group("what", "Which tiles; one of");
  what->add_option("--level", o.mesh.level, "All tiles of this level; 0 is the root, the coarsest");
  what->add_option("--error", o.mesh.error_m, "The coarsest tiles whose measured error is at most this, in metres");
  what->require_option(1);
  app.add_flag("--overwrite", o.overwrite, "Replace the file if it exists");
  app.add_flag("--quiet", o.quiet, "Print nothing but errors");
}

Expected<void> check_output(const Options& o) {
  std::error_code ec;
  if (auto writable = tintree::app::check_output_file(o.mesh.path, {&o.tree, 1}); !writable) return writable;
  if (std::filesystem::exists(o.mesh.path, ec) && !o.overwrite) {
    return fail(ErrorCode::kIo, "exists; give another name, or --overwrite to replace it", o.mesh.path);
  }
  return {};
}

Expected<void> run(const Options& o) {
  if (o.mesh.error_m && !(*o.mesh.error_m >= 0 && std::isfinite(*o.mesh.error_m))) {
    return fail(ErrorCode::kUsage, "must be a number of metres, 0 or more", "--error");
  }
  const auto store = tintree::cache::TileStore::open(o.tree);
  if (!store) return tl::unexpected(store.error());
  if (auto output = check_output(o); !output) return output;
  tintree::app::Progress progress(o.quiet);
  tintree::exporter::ExportOptions options = o.mesh;
  options.progress = [&progress](std::uint64_t done, std::uint64_t total) {
    progress.report("Exporting tiles", done, total);
    return !tintree::app::stop_requested();
  };
  const auto summary = export_tree(*store, options);
  progress.close();
  if (!summary) return tl::unexpected(summary.error());
  if (!o.quiet) {
    fmt::print("{}: {} vertices, {} triangles from {} tiles; measured error at most {:.6g} m\n", options.path,
               summary->vertices, summary->triangles, summary->tiles, summary->error_m);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes a level of a tree, or its coarsest tiles within an error, as one mesh.", "tintree-export");
  Options options;
  declare(app, options);
  return tintree::app::run_program(app, argc, argv, [&options] { return run(options); });
}
