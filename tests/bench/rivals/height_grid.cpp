#include "tests/bench/rivals/height_grid.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

namespace tintree::bench {
namespace {

/// A missing sample of no weight does no harm.
double part(double weight, double height) { return weight == 0 ? 0 : weight * height; }

}  // namespace

double HeightGrid::surface(double column, double row) const {
  const int i = std::clamp(static_cast<int>(std::floor(column)), 0, columns - 2);
  const int j = std::clamp(static_cast<int>(std::floor(row)), 0, rows - 2);
  const double u = column - i;
  const double v = row - j;
  if (u >= v) return part(1 - u, at(i, j)) + part(u - v, at(i + 1, j)) + part(v, at(i + 1, j + 1));
  return part(1 - v, at(i, j)) + part(v - u, at(i, j + 1)) + part(u, at(i + 1, j + 1));
}

bool HeightGrid::has_lower(int column, int row) const {
  return !std::isnan(at(column, row) + at(column, row + 1) + at(column + 1, row + 1));
}

bool HeightGrid::has_upper(int column, int row) const {
  return !std::isnan(at(column, row) + at(column + 1, row + 1) + at(column + 1, row));
}

bool HeightGrid::has_holes() const {
  return std::ranges::any_of(heights_m, [](double height) { return std::isnan(height); });
}

Expected<HeightGrid> read_grid(const std::string& path, HeightGrid shape) {
  if (shape.columns < 2 || shape.rows < 2) return fail(ErrorCode::kUsage, "needs two columns and rows or more", path);
  shape.heights_m.resize(static_cast<std::size_t>(shape.columns) * static_cast<std::size_t>(shape.rows));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(shape.heights_m.data()),
            static_cast<std::streamsize>(shape.heights_m.size() * sizeof(double)));
  if (!file || file.peek() != std::ifstream::traits_type::eof()) {
    return fail(ErrorCode::kIo, "cannot be read, or does not hold as many samples as stated", path);
  }
  return shape;
}

}  // namespace tintree::bench
