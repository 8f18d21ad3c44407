#include "tests/bench/rivals/height_grid.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

namespace tintree::bench {

double HeightGrid::surface(double column, double row) const {
  const int i = std::clamp(static_cast<int>(std::floor(column)), 0, columns - 2);
  const int j = std::clamp(static_cast<int>(std::floor(row)), 0, rows - 2);
  const double u = column - i;
  const double v = row - j;
  const double nw = at(i, j);
  const double se = at(i + 1, j + 1);
  if (u >= v) {
    const double ne = at(i + 1, j);
    return nw + u * (ne - nw) + v * (se - ne);
  }
  const double sw = at(i, j + 1);
  return nw + v * (sw - nw) + u * (se - sw);
}

Expected<HeightGrid> read_grid(const std::string& path, HeightGrid shape) {
  if (shape.columns < 2 || shape.rows < 2) return fail(ErrorCode::kUsage, "needs two columns and rows or more", path);
  shape.heights_m.resize(static_cast<std::size_t>(shape.columns) * static_cast<std::size_t>(shape.rows));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(shape.heights_m.data()),
            static_cast<std::streamsize>(shape.heights_m.size() * sizeof(float)));
  if (!file || file.peek() != std::ifstream::traits_type::eof()) {
    return fail(ErrorCode::kIo, "cannot be read, or does not hold as many samples as stated", path);
  }
  return shape;
}

}  // namespace tintree::bench
