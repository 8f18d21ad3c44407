#include "apps/audit/error_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/audit/picture_size.h"

namespace tintree::audit {
namespace {

/// The larger of both; NaN only when both are.
void raise(float& pixel, double error_m) {
  if (!(static_cast<double>(pixel) >= error_m) && !std::isnan(error_m)) pixel = static_cast<float>(error_m);
}

}  // namespace

ErrorMap::ErrorMap(const codec::CellRect& cells, int longest_px) : cells_(cells) {
  const auto [width, height] = picture_size(cells, longest_px, 1);
  width_px_ = width;
  height_px_ = height;
  errors_m_.assign(static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_),
                   std::numeric_limits<float>::quiet_NaN());
}

int ErrorMap::x_of(std::int64_t column) const {
  const std::int64_t columns = cells_.column1 - cells_.column0 + 1;
  return static_cast<int>(std::clamp<std::int64_t>((column - cells_.column0) * width_px_ / columns, 0, width_px_ - 1));
}

int ErrorMap::y_of(std::int64_t row) const {
  const std::int64_t rows = cells_.row1 - cells_.row0 + 1;
  return static_cast<int>(std::clamp<std::int64_t>((row - cells_.row0) * height_px_ / rows, 0, height_px_ - 1));
}

void ErrorMap::add(std::int64_t column0, std::int64_t row0, const SampleErrors& errors, const Peak& peak) {
  // Columns at which a pixel begins, so that the samples between them are looked at without a division.
  std::vector<std::int64_t> begins;
  std::vector<int> pixel;
  for (std::int64_t i = 0; i < errors.columns; ++i) {
    const int x = x_of(column0 + errors.column0 + i);
    if (!pixel.empty() && pixel.back() == x) continue;
    begins.push_back(i);
    pixel.push_back(x);
  }
  begins.push_back(errors.columns);

  const std::scoped_lock lock(turn_);
  for (std::int64_t j = 0; j < errors.rows; ++j) {
    const double* line = errors.values_m.data() + j * errors.columns;
    float* out = errors_m_.data() + std::ptrdiff_t{y_of(row0 + errors.row0 + j)} * width_px_;
    for (std::size_t p = 0; p < pixel.size(); ++p) {
      double largest = -1;
      for (std::int64_t i = begins[p]; i < begins[p + 1]; ++i) largest = line[i] > largest ? line[i] : largest;
      if (largest >= 0) raise(out[pixel[p]], largest);
    }
  }
  if (peak.value_m <= 0) return;
  const auto column = static_cast<std::int64_t>(std::floor(peak.column));
  const auto row = static_cast<std::int64_t>(std::floor(peak.row));
  raise(errors_m_[static_cast<std::size_t>(y_of(row0 + row) * width_px_ + x_of(column0 + column))], peak.value_m);
}

}  // namespace tintree::audit
