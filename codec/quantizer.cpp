#include "codec/quantizer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace tintree::codec {
namespace {

constexpr double kLeastGain = 1e-7;

/// Walks rising heights and the level nearest to each: `visit(height, level)`.
template <typename Visit>
void for_each_nearest(const std::vector<double>& values, std::span<const HeightWeight> heights, const Visit& visit) {
  std::size_t level = 0;
  for (const HeightWeight& h : heights) {
    while (level + 1 < values.size() && values[level + 1] - h.height_m < h.height_m - values[level]) ++level;
    visit(h, level);
  }
}

double square_error(const std::vector<double>& values, std::span<const HeightWeight> heights) {
  double sum = 0;
  for_each_nearest(values, heights, [&](const HeightWeight& h, std::size_t level) {
    const double gap = h.height_m - values[level];
    sum += h.weight * gap * gap;
  });
  return sum;
}

/// Different heights at equal shares of the cube roots of the weights.
std::vector<double> first_levels(std::span<const HeightWeight> heights, std::size_t levels) {
  double total = 0;
  for (const HeightWeight& h : heights) total += std::cbrt(h.weight);
  std::vector<double> values;
  double sum = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    sum += std::cbrt(heights[i].weight);
    const double due = (static_cast<double>(values.size()) + 0.5) * total / static_cast<double>(levels);
    const bool last_chance = heights.size() - i == levels - values.size();
    if (values.size() < levels && (sum >= due || last_chance)) values.push_back(heights[i].height_m);
  }
  return values;
}

/// Gives levels without a height those heights that have most of the distortion.
void restart_empty(std::vector<double>& values, std::span<const HeightWeight> heights) {
  std::vector<bool> used(values.size(), false);
  std::vector<std::pair<double, double>> worst;  // distortion, height
  for_each_nearest(values, heights, [&](const HeightWeight& h, std::size_t level) {
    used[level] = true;
    const double gap = h.height_m - values[level];
    if (gap != 0) worst.emplace_back(h.weight * gap * gap, h.height_m);
  });
  const auto empty = static_cast<std::size_t>(std::ranges::count(used, false));
  if (empty == 0) return;
  const std::size_t moved = std::min(empty, worst.size());
  std::ranges::partial_sort(worst, worst.begin() + static_cast<std::ptrdiff_t>(moved), std::greater<>());
  std::size_t next = 0;
  for (std::size_t i = 0; i < values.size() && next < moved; ++i) {
    if (!used[i]) values[i] = worst[next++].second;
  }
  std::ranges::sort(values);
}

/// Every level goes to the mean of its heights; one without stays.
void move_to_means(std::vector<double>& values, std::span<const HeightWeight> heights) {
  std::vector<double> sums(values.size(), 0);
  std::vector<double> weights(values.size(), 0);
  for_each_nearest(values, heights, [&](const HeightWeight& h, std::size_t level) {
    // Relative to the level, so that heights far from 0 lose nothing.
    sums[level] += h.weight * (h.height_m - values[level]);
    weights[level] += h.weight;
  });
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (weights[i] > 0) values[i] += sums[i] / weights[i];
  }
}

}  // namespace

std::size_t Quantizer::index(double height_m) const {
  const auto above = std::ranges::lower_bound(values_m, height_m);
  if (above == values_m.begin()) return 0;
  const auto i = static_cast<std::size_t>(above - values_m.begin());
  return i == values_m.size() || height_m - values_m[i - 1] <= values_m[i] - height_m ? i - 1 : i;
}

Distortion distortion(const Quantizer& quantizer, std::span<const HeightWeight> heights) {
  Distortion out;
  double weight = 0;
  for_each_nearest(quantizer.values_m, heights, [&](const HeightWeight& h, std::size_t level) {
    const double gap = std::abs(h.height_m - quantizer.values_m[level]);
    out.mean_square += h.weight * gap * gap;
    out.max_m = std::max(out.max_m, gap);
    weight += h.weight;
  });
  if (weight > 0) out.mean_square /= weight;
  return out;
}

double psnr_db(double range_m, double mean_square) {
  return mean_square > 0 ? 10 * std::log10(range_m * range_m / mean_square) : std::numeric_limits<double>::infinity();
}

Quantizer uniform_quantizer(double low_m, double high_m, std::size_t levels) {
  Quantizer out;
  const double step = (high_m - low_m) / static_cast<double>(levels);
  if (!(step > 0)) return {{low_m}};
  for (std::size_t i = 0; i < levels; ++i) out.values_m.push_back(low_m + (static_cast<double>(i) + 0.5) * step);
  return out;
}

LloydMaxDesign lloyd_max_quantizer(std::span<const HeightWeight> heights, std::size_t levels, int most_iterations) {
  LloydMaxDesign out;
  std::vector<double>& values = out.quantizer.values_m;
  if (heights.size() <= levels) {
    for (const HeightWeight& h : heights) values.push_back(h.height_m);
    out.converged = true;
    return out;
  }
  values = first_levels(heights, levels);
  double before = square_error(values, heights);
  while (!out.converged && out.iterations < most_iterations) {
    ++out.iterations;
    std::vector<double> moved = values;
    restart_empty(moved, heights);
    move_to_means(moved, heights);
    const double after = square_error(moved, heights);
    out.converged = !(after < before * (1 - kLeastGain));
    if (after < before) values = std::move(moved);
    before = std::min(before, after);
  }
  return out;
}

}  // namespace tintree::codec
