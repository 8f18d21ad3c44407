#include "apps/audit/error_histogram.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace tintree::audit {

void ErrorHistogram::add(std::span<const double> errors_m, double bound_m) {
  const double scale = static_cast<double>(kBins) / bound_m;
  constexpr auto kBeyond = static_cast<double>(kBins);
  for (const double e : errors_m) {
    const double share = e * scale;
    if (share < kBeyond) {
      ++counts_[static_cast<std::size_t>(share)];
    } else if (share >= kBeyond) {
      // The bound itself is within it.
      ++counts_[e > bound_m * (1 + 1e-9) ? kBins : kBins - 1];
    }
  }
}

void ErrorHistogram::add(const ErrorHistogram& other) {
  std::ranges::transform(counts_, other.counts_, counts_.begin(), std::plus<>());
}

std::uint64_t ErrorHistogram::total() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
}

std::vector<std::uint64_t> ErrorHistogram::bars(std::size_t bars) const {
  std::vector<std::uint64_t> out(bars, 0);
  for (std::size_t i = 0; i < kBins; ++i) out[i * bars / kBins] += counts_[i];
  return out;
}

double ErrorHistogram::quantile(double part) const {
  const std::uint64_t all = total();
  if (all == 0) return 0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(part * static_cast<double>(all)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    seen += counts_[i];
    if (seen >= wanted) return static_cast<double>(i + 1) / static_cast<double>(kBins);
  }
  return std::numeric_limits<double>::infinity();
}

double p999_m(const ErrorHistogram& histogram, double bound_m, double largest_m) {
  return std::min(histogram.quantile(0.999) * bound_m, largest_m);
}

}  // namespace tintree::audit
