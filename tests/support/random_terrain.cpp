#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/adversarial_terrain.h"

namespace tintree::test {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

int one_of(Random& random, int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); }

/// A walk that steps from its neighbours to the north and west; 0 at the north-west corner.
std::vector<double> random_walk(Random& random, int columns, int rows, double roughness) {
  std::vector<double> h(static_cast<std::size_t>(columns * rows));
  const auto at = [&](int c, int r) -> double& { return h[static_cast<std::size_t>(r * columns + c)]; };
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double west = c > 0 ? at(c - 1, r) : at(0, r > 0 ? r - 1 : 0);
      const double north = r > 0 ? at(c, r - 1) : west;
      at(c, r) = (west + north) / 2 + roughness * uniform(random, -1, 1);
    }
  }
  return h;
}

}  // namespace

AdversarialTerrain random_terrain(unsigned seed) {
  Random random(seed);
  AdversarialTerrain out;
  out.name = "random_" + std::to_string(seed);
  out.about = "a random walk of any scale";
  out.everyday = false;
  out.columns = 2 + one_of(random, 69);
  out.rows = 2 + one_of(random, 69);
  const double scale = std::pow(10.0, uniform(random, -4, 4));
  const double offsets[] = {0, 0, 3.3 * scale, -100 * scale, 1e4 * scale};
  const double offset = offsets[one_of(random, 5)];
  const double slopes[] = {0, 0, 0.3 * scale, -20 * scale};
  const double slope = slopes[one_of(random, 4)];
  auto heights = std::make_shared<std::vector<double>>(
      random_walk(random, out.columns, out.rows, one_of(random, 4) == 0 ? 0 : scale));
  const double spikes = one_of(random, 3) == 0 ? 0.01 : 0;
  const double chances[] = {0, 0, 0.02, 0.3};
  const double missing = chances[one_of(random, 4)];
  const int clump = 1 + one_of(random, 4);
  // Multiples of an odd number of eighths of the scale's power of two: often halfway between lattice heights.
  const double quantum = one_of(random, 3) == 0 ? std::exp2(std::floor(std::log2(scale))) / 8 : 0;
  for (int r = 0; r < out.rows; ++r) {
    for (int c = 0; c < out.columns; ++c) {
      double& h = (*heights)[static_cast<std::size_t>(r * out.columns + c)];
      h += offset + slope * (c - 0.7 * r);
      if (uniform(random, 0, 1) < spikes) h += 100 * scale * uniform(random, -1, 1);
      if (quantum > 0) h = std::floor(h / quantum) * quantum;
      if (noise(c / clump, r / clump, seed) < missing) h = kMissing;
    }
  }
  out.height = [heights, columns = out.columns](int c, int r) {
    return (*heights)[static_cast<std::size_t>(r * columns + c)];
  };
  return out;
}

}  // namespace tintree::test
