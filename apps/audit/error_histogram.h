#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::audit {

/// How often which error occurs, as shares of a bound. Shares are kept to 1/2048; whole counts only, so sums
/// do not depend on their order. 16 KiB.
class ErrorHistogram {
 public:
  static constexpr std::size_t kBins = 2048;  ///< From 0 to the bound.

  ErrorHistogram() : counts_(kBins + 1, 0) {}

  /// Errors in metres, none negative; NaN does not count.
  void add(std::span<const double> errors_m, double bound_m);
  void add(const ErrorHistogram& other);

  std::uint64_t total() const;
  /// How many errors exceed the bound.
  std::uint64_t beyond() const { return counts_[kBins]; }
  /// Counts in `bars` (a power of two up to kBins) equal steps from 0 to the bound.
  std::vector<std::uint64_t> bars(std::size_t bars) const;
  /// The share of the bound that `part` (0 to 1) of the errors do not exceed, rounded up to the bin; infinite
  /// where that lies beyond the bound, 0 when nothing was counted.
  double quantile(double part) const;

 private:
  std::vector<std::uint64_t> counts_;  ///< The last one: beyond the bound.
};

/// What 99.9 % of the counted errors do not exceed, metres; `largest_m` is the largest of them.
double p999_m(const ErrorHistogram& histogram, double bound_m, double largest_m);

}  // namespace tintree::audit
