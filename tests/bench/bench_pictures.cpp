/// bench_pictures: bytes, quality and decoding time of the codecs of textures and normal maps over all tiles that a
/// photo covers wholly, and over those of a DEM. Prints tables in Markdown for docs/performance.md.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <limits>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "apps/common/program.h"
#include "cache/ortho_source.h"
#include "cache/raster_source.h"
#include "codec/normal_codec.h"
#include "codec/texture_codec.h"

namespace tintree::bench {
namespace {

constexpr int kRepeats = 5;
constexpr int kCells = 256;

struct Options {
  std::string photo;
  std::string photo_dem;
  std::string normal_dem;
  double texel_samples = 0.5;
};

/// The least processor time of some repeats.
template <typename Work>
double seconds_of(const Work& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRepeats; ++i) {
    const std::clock_t before = std::clock();
    work();
    least = std::min(least, static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
  }
  return least;
}

struct Sums {
  int pictures = 0;
  double texels = 0;
  double bytes = 0;
  double squares = 0;  ///< Of all components' differences; of a normal's angle, degrees.
  double encode_s = 0;
  double upload_s = 0;  ///< From the payload to what a card with the format takes,
  double unpack_s = 0;  ///< and to plain texels.

  void print(const std::string& what, const std::string& quality) const {
    fmt::print("| {} | {} | {:.3f} | {} | {:.2f} | {:.3f} | {:.2f} |\n", what, pictures, 8 * bytes / texels, quality,
               1e3 * encode_s / pictures, 1e3 * upload_s / pictures, 1e3 * unpack_s / pictures);
  }
};

void print_head(const char* title) {
  fmt::print("\n{}\n\n| codec | pictures | bits a texel | quality | encode ms | to upload ms | to texels ms |\n",
             title);
  fmt::print("|---|---|---|---|---|---|---|\n");
}

Expected<std::vector<codec::ColorImage>> covered_tiles(const Options& o) {
  const auto dem = cache::RasterSource::open(o.photo_dem);
  if (!dem) return tl::unexpected(dem.error());
  const auto photo = cache::OrthoSource::open({o.photo}, dem->info());
  if (!photo) return tl::unexpected(photo.error());
  const auto across = static_cast<int>(std::lround(kCells / o.texel_samples));
  std::vector<codec::ColorImage> out;
  for (std::int64_t row = 0; row + kCells < dem->info().rows; row += kCells) {
    for (std::int64_t column = 0; column + kCells < dem->info().columns; column += kCells) {
      auto window =
          photo->read(o.texel_samples, column / kCells * across, row / kCells * across, across + 1, across + 1);
      if (!window) return tl::unexpected(window.error());
      codec::ColorImage image(across + 1);
      image.rgba = std::move(window->rgba);
      bool whole = true;
      for (std::size_t i = 3; i < image.rgba.size(); i += 4) whole = whole && image.rgba[i] == 255;
      if (whole) out.push_back(std::move(image));
    }
  }
  return out;
}

Expected<void> measure_textures(const Options& o) {
  const auto tiles = covered_tiles(o);
  if (!tiles) return tl::unexpected(tiles.error());
  if (tiles->empty()) return fail(ErrorCode::kBadData, "covers no tile wholly", o.photo);
  print_head(fmt::format("Textures of {} x {} texels", tiles->front().size, tiles->front().size).c_str());
  for (const char* name : {"bc1", "jpeg"}) {
    const codec::TextureCodec& codec = *codec::find_texture_codec(name);
    Sums sums;
    for (const codec::ColorImage& image : *tiles) {
      const auto payload = codec.encode(image);
      if (!payload) return tl::unexpected(payload.error());
      const auto decoded = codec.decode(*payload, image.size);
      if (!decoded) return tl::unexpected(decoded.error());
      for (std::size_t i = 0; i < image.rgba.size(); ++i)
        sums.squares += i % 4 == 3 ? 0 : std::pow(image.rgba[i] - decoded->rgba[i], 2);
      ++sums.pictures;
      sums.texels += static_cast<double>(image.size) * image.size;
      sums.bytes += static_cast<double>(payload->size());
      sums.encode_s += seconds_of([&] { static_cast<void>(codec.encode(image)); });
      sums.upload_s += seconds_of([&] { static_cast<void>(codec.pixels(*payload, image.size)); });
      sums.unpack_s += seconds_of([&] { static_cast<void>(codec.decode(*payload, image.size)); });
    }
    sums.print(name, fmt::format("{:.2f} dB", 10 * std::log10(255 * 255 * 3 * sums.texels / sums.squares)));
  }
  return {};
}

/// Means of the unit normals of `step` x `step` cells, by forward differences of the samples.
Expected<codec::NormalImage> normals_of(const cache::RasterSource& dem, std::int64_t column, std::int64_t row,
                                        int step) {
  const int side = (kCells + 1) * step + 1;
  std::vector<double> heights(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  if (auto read = dem.read(column, row, side, side, heights.data()); !read) return tl::unexpected(read.error());
  const auto at = [&](int x, int y) {
    return heights[static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x)];
  };
  codec::NormalImage out(kCells + 1);
  for (int y = 0; y < side - 1; ++y) {
    for (int x = 0; x < side - 1; ++x) {
      const double east = -(at(x + 1, y) - at(x, y)) / dem.info().dx_m;
      const double north = (at(x, y + 1) - at(x, y)) / dem.info().dy_m;
      const double share = 1 / (std::hypot(east, north, 1.0) * step * step);
      auto& v = out.at(x / step, y / step);
      for (const auto& [axis, part] : {std::pair(0, east), {1, north}, {2, 1.0}})
        v[static_cast<std::size_t>(axis)] += static_cast<float>(part * share);
    }
  }
  return out;
}

double angle_deg(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double dot = 0;
  for (std::size_t i = 0; i < 3; ++i) dot += static_cast<double>(a[i]) * static_cast<double>(b[i]);
  const double lengths = std::hypot(a[0], a[1], a[2]) * std::hypot(b[0], b[1], b[2]);
  return std::acos(std::clamp(dot / lengths, -1.0, 1.0)) * 57.29577951308232;
}

Expected<void> measure_normals(const Options& o) {
  const auto dem = cache::RasterSource::open(o.normal_dem);
  if (!dem) return tl::unexpected(dem.error());
  print_head("Normal maps of 257 x 257 texels");
  for (const int step : {1, 4}) {
    Sums sums;
    double length_squares = 0;
    double part_squares = 0;
    const int tile = kCells * step;
    for (std::int64_t row = 0; row + tile + step < dem->info().rows; row += 1024) {
      for (std::int64_t column = 0; column + tile + step < dem->info().columns; column += 1024) {
        const auto image = normals_of(*dem, column, row, step);
        if (!image) return tl::unexpected(image.error());
        const auto payload = codec::encode_normals(*image);
        const auto decoded = codec::decode_normals(payload, image->size);
        if (!decoded) return tl::unexpected(decoded.error());
        for (std::size_t i = 0; i < image->vectors.size(); ++i) {
          const auto& a = image->vectors[i];
          const auto& b = decoded->vectors[i];
          sums.squares += std::pow(angle_deg(a, b), 2);
          for (std::size_t k = 0; k < 3; ++k)
            part_squares += std::pow(static_cast<double>(a[k]) - static_cast<double>(b[k]), 2);
          length_squares += std::pow(std::hypot(a[0], a[1], a[2]) - std::hypot(b[0], b[1], b[2]), 2);
        }
        ++sums.pictures;
        sums.texels += static_cast<double>(image->vectors.size());
        sums.bytes += static_cast<double>(payload.size());
        sums.encode_s += seconds_of([&] { static_cast<void>(codec::encode_normals(*image)); });
        sums.upload_s += seconds_of([&] { static_cast<void>(codec::normal_pixels(payload, image->size)); });
        sums.unpack_s += seconds_of([&] { static_cast<void>(codec::decode_normals(payload, image->size)); });
      }
    }
    // A normal's parts range from -1 to 1.
    sums.print(step == 1 ? "BC5, unit normals" : "BC5 and BC4, means of 4 x 4",
               fmt::format("{:.1f} dB, {:.2f}° RMS, lengths {:.4f} RMS",
                           10 * std::log10(4 * 3 * sums.texels / std::max(part_squares, 1e-30)),
                           std::sqrt(sums.squares / sums.texels), std::sqrt(length_squares / sums.texels)));
  }
  return {};
}

Expected<void> run(const Options& o) {
  if (auto done = measure_textures(o); !done) return done;
  return measure_normals(o);
}

}  // namespace
}  // namespace tintree::bench

int main(int argc, char** argv) {
  using namespace tintree;
  bench::Options o;
  CLI::App app{"Bytes, quality and decoding time of textures and normal maps.", "bench_pictures"};
  app.add_option("PHOTO", o.photo)->required();
  app.add_option("PHOTO_DEM", o.photo_dem, "The DEM that the photo lies on")->required();
  app.add_option("NORMAL_DEM", o.normal_dem, "The DEM whose normals are taken")->required();
  app.add_option("--texel", o.texel_samples, "Side of a texel in samples of PHOTO_DEM")->check(CLI::PositiveNumber);
  return app::run_program(app, argc, argv, [&] { return bench::run(o); });
}
