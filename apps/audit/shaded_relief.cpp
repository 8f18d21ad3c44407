#include "apps/audit/shaded_relief.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "apps/audit/picture_size.h"

namespace tintree::audit {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Root mean square slope that the exaggeration aims at.
constexpr double kSlope = 0.45;
constexpr double kMostGain = 30;

std::int64_t sample_at(std::int64_t first, std::int64_t last, int px, int pixel) {
  return first + ((last - first) * pixel + (px - 1) / 2) / (px - 1);
}

struct Slope {
  double east = 0;
  double north = 0;
};

/// NaN where a neighbour is missing.
Slope slope_at(const HeightPicture& p, const codec::TreeLayout& layout, int x, int y) {
  const int x0 = std::max(x - 1, 0);
  const int x1 = std::min(x + 1, p.width_px - 1);
  const int y0 = std::max(y - 1, 0);
  const int y1 = std::min(y + 1, p.height_px - 1);
  const double run_x = static_cast<double>(p.column(x1) - p.column(x0)) * layout.dx_m;
  const double run_y = static_cast<double>(p.row(y1) - p.row(y0)) * layout.dy_m;
  return {(p.at(x1, y) - p.at(x0, y)) / run_x, (p.at(x, y0) - p.at(x, y1)) / run_y};
}

/// Fills the pixels under a triangle with its heights.
void fill(HeightPicture& picture, const TileSurface& s, const codec::Triangle& t) {
  std::array<std::array<double, 3>, 3> p{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner& c = s.corners[t[k]];
    p[k] = {static_cast<double>(s.cells.column0) + static_cast<double>(c.x) / s.units,
            static_cast<double>(s.cells.row0) + static_cast<double>(c.y) / s.units, c.z_m};
  }
  const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b, double column, double row) {
    return (b[0] - a[0]) * (row - a[1]) - (b[1] - a[1]) * (column - a[0]);
  };
  const double area = cross(p[0], p[1], p[2][0], p[2][1]);
  const auto pixel = [](double at, std::int64_t first, std::int64_t last, int px) {
    return (at - static_cast<double>(first)) * (px - 1) / static_cast<double>(last - first);
  };
  const auto [c0, c1] = std::minmax({p[0][0], p[1][0], p[2][0]});
  const auto [r0, r1] = std::minmax({p[0][1], p[1][1], p[2][1]});
  const codec::CellRect& w = picture.cells;
  const int x0 = std::max(static_cast<int>(pixel(c0, w.column0, w.column1, picture.width_px)) - 1, 0);
  const int x1 =
      std::min(static_cast<int>(pixel(c1, w.column0, w.column1, picture.width_px)) + 1, picture.width_px - 1);
  const int y0 = std::max(static_cast<int>(pixel(r0, w.row0, w.row1, picture.height_px)) - 1, 0);
  const int y1 = std::min(static_cast<int>(pixel(r1, w.row0, w.row1, picture.height_px)) + 1, picture.height_px - 1);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const auto column = static_cast<double>(picture.column(x));
      const auto row = static_cast<double>(picture.row(y));
      const double a = cross(p[1], p[2], column, row) / area;
      const double b = cross(p[2], p[0], column, row) / area;
      const double c = 1 - a - b;
      if (std::min({a, b, c}) < -1e-9) continue;
      picture.heights_m[static_cast<std::size_t>(y * picture.width_px + x)] = a * p[0][2] + b * p[1][2] + c * p[2][2];
    }
  }
}

}  // namespace

HeightPicture::HeightPicture(const codec::CellRect& rectangle, int longest_px) : cells(rectangle) {
  const auto [width, height] = picture_size(cells, longest_px, 2);
  width_px = width;
  height_px = height;
  heights_m.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), kNaN);
}

std::int64_t HeightPicture::column(int x_px) const { return sample_at(cells.column0, cells.column1, width_px, x_px); }
std::int64_t HeightPicture::row(int y_px) const { return sample_at(cells.row0, cells.row1, height_px, y_px); }

Expected<HeightPicture> picture_of_dem(const cache::RasterSource& source, const codec::CellRect& cells,
                                       int longest_px) {
  HeightPicture picture(cells, longest_px);
  std::vector<double> line(static_cast<std::size_t>(cells.column1 - cells.column0 + 1));
  for (int y = 0; y < picture.height_px; ++y) {
    const auto width = static_cast<std::int64_t>(line.size());
    if (auto read = source.read(cells.column0, picture.row(y), width, 1, line.data()); !read) {
      return tl::unexpected(read.error());
    }
    for (int x = 0; x < picture.width_px; ++x) {
      picture.heights_m[static_cast<std::size_t>(y * picture.width_px + x)] =
          line[static_cast<std::size_t>(picture.column(x) - cells.column0)];
    }
  }
  return picture;
}

HeightPicture picture_of_mesh(const TileSurface& surface, int longest_px) {
  HeightPicture picture(surface.cells, longest_px);
  for (const codec::Triangle& t : surface.triangles) fill(picture, surface, t);
  return picture;
}

double relief_gain(const HeightPicture& picture, const codec::TreeLayout& layout) {
  double squares = 0;
  double count = 0;
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) {
      const Slope s = slope_at(picture, layout, x, y);
      const double square = s.east * s.east + s.north * s.north;
      if (std::isnan(square)) continue;
      squares += square;
      count += 1;
    }
  }
  const double rms = count > 0 ? std::sqrt(squares / count) : 0;
  return rms > 0 ? std::clamp(kSlope / rms, 1.0, kMostGain) : 1;
}

app::RgbImage shade(const HeightPicture& picture, const codec::TreeLayout& layout, double gain) {
  app::RgbImage image(picture.width_px, picture.height_px);
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) {
      const Slope s = slope_at(picture, layout, x, y);
      const double e = s.east * gain;
      const double n = s.north * gain;
      // The light comes from (-1, 1, sqrt 2) / 2.
      const double light = (0.5 * e - 0.5 * n + std::sqrt(0.5)) / std::sqrt(1 + e * e + n * n);
      const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.12 + 0.86 * light, 0.0, 1.0)));
      const Rgb color = std::isnan(light) ? kNoSurface : Rgb{grey, grey, grey};
      std::ranges::copy(color, image.at(x, y));
    }
  }
  return image;
}

}  // namespace tintree::audit
