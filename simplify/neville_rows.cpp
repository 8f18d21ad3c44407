#include "simplify/neville_rows.h"

#include <cmath>
#include <limits>
#include <utility>

namespace tintree::simplify {
namespace {

double filtered(const std::array<std::vector<double>, 4>& rows, std::size_t x) {
  const auto at = [&](std::size_t j, std::size_t i) { return rows[j][x + i]; };
  const double nearest = at(1, 1) + at(1, 2) + at(2, 1) + at(2, 2);
  const double around = at(0, 1) + at(0, 2) + at(3, 1) + at(3, 2) + at(1, 0) + at(2, 0) + at(1, 3) + at(2, 3);
  const double value = (10 * nearest - around) / 32;
  if (!std::isnan(value)) return value;
  double sum = 0;
  int count = 0;
  for (const double h : {at(1, 1), at(1, 2), at(2, 1), at(2, 2)}) {
    if (std::isnan(h)) continue;
    sum += h;
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / count;
}

}  // namespace

NevilleRows::NevilleRows(const SampleRows& samples, int layer, std::int64_t column, std::int64_t row, int width)
    : samples_(samples), column_(column), row_(row), out_(static_cast<std::size_t>(width)) {
  if (layer == 0) return;
  finer_ = std::make_unique<NevilleRows>(samples, layer - 1, 2 * column - 1, 2 * row - 1, 2 * width + 2);
}

const std::vector<double>& NevilleRows::next() {
  if (!finer_) {
    samples_(column_, row_++, out_);
    return out_;
  }
  if (begun_) {
    std::swap(finer_rows_[0], finer_rows_[2]);
    std::swap(finer_rows_[1], finer_rows_[3]);
  } else {
    for (const std::size_t j : {0U, 1U}) finer_rows_[j] = finer_->next();
    begun_ = true;
  }
  for (const std::size_t j : {2U, 3U}) finer_rows_[j] = finer_->next();
  for (std::size_t x = 0; x < out_.size(); ++x) out_[x] = filtered(finer_rows_, 2 * x);
  return out_;
}

}  // namespace tintree::simplify
