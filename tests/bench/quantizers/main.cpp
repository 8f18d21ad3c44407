/// bench_quantizers: rate against distortion of uniform and Lloyd-Max quantisers, one a tile, over every sample of a
/// DEM (Fowler et al., figure 2), and the heights that they leave. JSON on standard output.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/common/program.h"
#include "cache/raster_source.h"
#include "codec/quantizer.h"
#include "tests/bench/rivals/cpu_clock.h"

namespace {

using namespace tintree;

constexpr std::int64_t kTileSamples = 256;

struct Tile {
  std::vector<std::size_t> samples;  ///< Those that are there.
  std::vector<codec::HeightWeight> histogram;
};

struct Dem {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::vector<double> heights_m;
  std::vector<Tile> tiles;
  double range_m = 0;
};

Expected<Dem> read(const std::string& path) {
  auto source = cache::RasterSource::open(path);
  if (!source) return tl::unexpected(source.error());
  Dem dem{source->info().columns, source->info().rows, {}, {}, 0};
  dem.heights_m.resize(static_cast<std::size_t>(dem.columns * dem.rows));
  if (auto done = source->read(0, 0, dem.columns, dem.rows, dem.heights_m.data()); !done)
    return tl::unexpected(done.error());
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::int64_t y0 = 0; y0 < dem.rows; y0 += kTileSamples) {
    for (std::int64_t x0 = 0; x0 < dem.columns; x0 += kTileSamples) {
      Tile tile;
      std::vector<double> heights;
      for (std::int64_t y = y0; y < std::min(y0 + kTileSamples, dem.rows); ++y) {
        for (std::int64_t x = x0; x < std::min(x0 + kTileSamples, dem.columns); ++x) {
          const auto i = static_cast<std::size_t>(y * dem.columns + x);
          if (std::isnan(dem.heights_m[i])) continue;
          tile.samples.push_back(i);
          heights.push_back(dem.heights_m[i]);
        }
      }
      if (heights.empty()) continue;
      std::ranges::sort(heights);
      low = std::min(low, heights.front());
      high = std::max(high, heights.back());
      for (const double h : heights) {
        if (tile.histogram.empty() || tile.histogram.back().height_m != h) tile.histogram.push_back({h, 0});
        ++tile.histogram.back().weight;
      }
      dem.tiles.push_back(std::move(tile));
    }
  }
  dem.range_m = high - low;
  return dem;
}

codec::LloydMaxDesign design(const Tile& tile, bool optimal, std::size_t levels) {
  if (optimal) return codec::lloyd_max_quantizer(tile.histogram, levels);
  return {codec::uniform_quantizer(tile.histogram.front().height_m, tile.histogram.back().height_m, levels), 0, true};
}

/// Quantises every tile; writes the heights that are left, as floats, to `left` unless that is empty.
Expected<nlohmann::json> quantize(const Dem& dem, bool optimal, int bits, const std::string& left) {
  const std::size_t levels = std::size_t{1} << bits;
  std::vector<codec::Quantizer> quantizers;
  int most_iterations = 0;
  std::size_t unconverged = 0;
  const bench::CpuClock clock;
  for (const Tile& tile : dem.tiles) {
    auto made = design(tile, optimal, levels);
    most_iterations = std::max(most_iterations, made.iterations);
    unconverged += made.converged ? 0 : 1;
    quantizers.push_back(std::move(made.quantizer));
  }
  const double design_seconds = clock.seconds();
  double squares = 0;
  double max_m = 0;
  double count = 0;
  std::vector<float> heights;
  if (!left.empty()) heights.assign(dem.heights_m.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t t = 0; t < dem.tiles.size(); ++t) {
    for (const std::size_t i : dem.tiles[t].samples) {
      const double value = quantizers[t].value(dem.heights_m[i]);
      const double gap = std::abs(value - dem.heights_m[i]);
      squares += gap * gap;
      max_m = std::max(max_m, gap);
      ++count;
      if (!left.empty()) heights[i] = static_cast<float>(value);
    }
  }
  if (!left.empty()) {
    std::ofstream out(left, std::ios::binary);
    out.write(reinterpret_cast<const char*>(heights.data()),
              static_cast<std::streamsize>(heights.size() * sizeof(float)));
    if (!out.flush()) return fail(ErrorCode::kIo, "cannot be written; check folder and disk space", left);
  }
  const double mean = squares / count;
  return nlohmann::json{{"quantizer", optimal ? "lloyd-max" : "uniform"},
                        {"bits_per_vertex", bits},
                        {"psnr_db", mean > 0 ? nlohmann::json(codec::psnr_db(dem.range_m, mean)) : nullptr},
                        {"rms_m", std::sqrt(mean)},
                        {"max_m", max_m},
                        {"design_seconds", design_seconds},
                        {"most_iterations", most_iterations},
                        {"tiles_cut_short", unconverged}};
}

Expected<void> run(const std::string& path, const std::string& folder, int most_bits) {
  const auto dem = read(path);
  if (!dem) return tl::unexpected(dem.error());
  nlohmann::json rates = nlohmann::json::array();
  for (const bool optimal : {false, true}) {
    for (int bits = 2; bits <= most_bits; ++bits) {
      const std::string left =
          folder.empty() ? "" : fmt::format("{}/{}_{}.f32", folder, optimal ? "lloyd-max" : "uniform", bits);
      auto rate = quantize(*dem, optimal, bits, left);
      if (!rate) return tl::unexpected(rate.error());
      rates.push_back(std::move(*rate));
    }
  }
  fmt::print("{}\n", nlohmann::json{{"columns", dem->columns},
                                    {"rows", dem->rows},
                                    {"tiles", dem->tiles.size()},
                                    {"range_m", dem->range_m},
                                    {"rates", rates}}
                         .dump());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Quantises a DEM's heights tile by tile and tells what that does to them", "bench_quantizers"};
  std::string dem;
  std::string folder;
  int most_bits = 16;
  app.add_option("DEM", dem, "Any raster that GDAL reads")->required();
  app.add_option("--heights", folder, "Write QUANTIZER_BITS.f32, the heights that are left, into this folder");
  app.add_option("--bits", most_bits, "The largest rate")->check(CLI::Range(2, 16))->capture_default_str();
  return app::run_program(app, argc, argv, [&] { return run(dem, folder, most_bits); });
}
