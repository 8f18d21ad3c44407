#include "simplify/node_values.h"

#include <cstdlib>

namespace tintree::simplify {
namespace {

using Value = std::array<float, 4>;

float weight_at(const HalvingFilter& filter, int offset) {
  return filter.weights[static_cast<std::size_t>(std::abs(offset))];
}

void add(Value& sum, const Value& v, float weight) {
  for (std::size_t k = 0; k < 4; ++k) sum[k] += weight * v[k];
}

}  // namespace

NodeValues halve(const NodeValues& fine, const HalvingFilter& filter) {
  const int reach = filter.reach;
  NodeValues rows((fine.width - 2 * reach + 1) / 2, fine.height);
  for (int y = 0; y < rows.height; ++y) {
    for (int x = 0; x < rows.width; ++x) {
      Value& sum = rows.at(x, y);
      for (int k = -reach; k <= reach; ++k) {
        const Value& v = fine.at(2 * x + reach + k, y);
        const float w = weight_at(filter, k);
        // Values weighted by their weight: what is not there adds nothing.
        add(sum, {v[0] * v[3], v[1] * v[3], v[2] * v[3], v[3]}, w);
      }
    }
  }
  NodeValues out(rows.width, (fine.height - 2 * reach + 1) / 2);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      Value& sum = out.at(x, y);
      for (int k = -reach; k <= reach; ++k) add(sum, rows.at(x, 2 * y + reach + k), weight_at(filter, k));
      if (sum[3] <= 0) {
        sum = {};
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) sum[k] /= sum[3];
    }
  }
  return out;
}

}  // namespace tintree::simplify
