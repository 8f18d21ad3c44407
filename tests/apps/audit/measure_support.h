#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "apps/audit/coverage.h"
#include "apps/audit/height_window.h"
#include "apps/audit/tile_surface.h"
#include "apps/audit/vertical_distance.h"
#include "apps/audit/window_bins.h"
#include "tests/support/regular_tree.h"
#include "tests/support/temp_dir.h"
#include "tests/support/test_raster.h"

namespace tintree::test {

/// A raster on disk, as HeightGrid and as RasterSource.
struct RasterFixture {
  RasterFixture(const RasterSpec& spec, const HeightFunction& height) : path(dir.file("dem.tif")) {
    write_raster(path, spec, height);
    grid = read_grid(path);
    auto opened = cache::RasterSource::open(path);
    if (!opened) throw std::runtime_error(opened.error().text());
    source = std::make_unique<cache::RasterSource>(std::move(*opened));
  }

  TempDir dir;
  std::string path;
  HeightGrid grid;
  std::unique_ptr<cache::RasterSource> source;
};

/// Calls visit(window, number) for all windows of a tile, as the audit does.
inline void for_windows(const cache::RasterSource& source, const audit::TileSurface& surface,
                        const audit::WindowBins& bins,
                        const std::function<void(const audit::HeightWindow&, std::size_t)>& visit) {
  audit::HeightWindow window;
  for (std::size_t i = 0; i < bins.count(); ++i) {
    if (auto read = window.read(source, surface.cells, bins.cells(i)); !read) {
      throw std::runtime_error(read.error().text());
    }
    visit(window, i);
  }
}

inline audit::VerticalDistance measure(const cache::RasterSource& source, const audit::TileSurface& surface) {
  const audit::WindowBins bins(surface);
  audit::VerticalDistance total;
  audit::VerticalMeasure measure;
  for_windows(source, surface, bins, [&](const audit::HeightWindow& window, std::size_t i) {
    total.add(measure.measure(surface, window, {bins.triangles(i), bins.edges(i), bins.corners(i)}));
  });
  return total;
}

/// All faults of coverage of a tile, windows and open edges together.
inline audit::Faults coverage_faults(const cache::RasterSource& source, const audit::TileSurface& surface) {
  const audit::WindowBins bins(surface);
  audit::Faults faults = audit::place_open_edges(surface);
  audit::Coverage coverage;
  for_windows(source, surface, bins, [&](const audit::HeightWindow& window, std::size_t i) {
    faults.add(coverage.check(surface, window, bins.edges(i)).faults);
  });
  return faults;
}

}  // namespace tintree::test
