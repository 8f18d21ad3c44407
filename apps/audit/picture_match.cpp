#include "apps/audit/picture_match.h"

#include <cmath>
#include <optional>

namespace tintree::audit {
namespace {

using Value = std::array<float, 3>;

/// Shifts that are tried, either way.
constexpr int kShifts = 2;
/// A shift that leaves less than this share of the squared differences is believed,
constexpr double kBetterShare = 0.7;
/// if so many texels could be compared.
constexpr std::size_t kEnough = 64;

struct Sum {
  double squares = 0;
  std::size_t texels = 0;
  double mean() const { return texels == 0 ? 0 : squares / static_cast<double>(texels); }
};

/// Tries all shifts; `compare(dx, dy)` sums the squared differences at one.
template <typename Compare>
PictureMatch best_of(const Compare& compare) {
  const Sum here = compare(0, 0);
  PictureMatch out{here.texels, std::sqrt(here.mean()), 0, 0};
  if (here.texels < kEnough) return out;
  double least = kBetterShare * here.mean();
  for (int dy = -kShifts; dy <= kShifts; ++dy) {
    for (int dx = -kShifts; dx <= kShifts; ++dx) {
      const Sum there = compare(dx, dy);
      if (there.texels < kEnough || there.mean() >= least) continue;
      least = there.mean();
      out.shift_x = dx;
      out.shift_y = dy;
    }
  }
  return out;
}

void add(Sum& sum, const Value& a, const Value& b) {
  for (std::size_t k = 0; k < 3; ++k) sum.squares += std::pow(static_cast<double>(a[k]) - b[k], 2);
  ++sum.texels;
}

/// The mean of 3 x 3 texels with the weights of a tent, where all are valid.
std::optional<Value> tent(const TexelGrid& grid, int x, int y) {
  if (x < 1 || y < 1 || x > grid.size - 2 || y > grid.size - 2) return std::nullopt;
  Value sum{};
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::size_t at = grid.index(x + dx, y + dy);
      if (!grid.valid[at]) return std::nullopt;
      const float weight = static_cast<float>((2 - std::abs(dx)) * (2 - std::abs(dy))) / 16;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * grid.values[at][k];
    }
  }
  return sum;
}

}  // namespace

PictureMatch match_pictures(const TexelGrid& picture, const TexelGrid& reference) {
  const int last = picture.size - 1 - kShifts;
  return best_of([&](int dx, int dy) {
    Sum sum;
    for (int y = kShifts; y <= last; ++y) {
      for (int x = kShifts; x <= last; ++x) {
        const std::size_t a = picture.index(x + dx, y + dy);
        const std::size_t b = reference.index(x, y);
        if (picture.valid[a] && reference.valid[b]) add(sum, picture.values[a], reference.values[b]);
      }
    }
    return sum;
  });
}

PictureMatch match_parent(const TexelGrid& picture, const TexelGrid& parent, int quadrant) {
  const int half = (picture.size - 1) / 2;
  const int x0 = (quadrant & 1) * half;
  const int y0 = (quadrant >> 1) * half;
  return best_of([&](int dx, int dy) {
    Sum sum;
    for (int v = 2; v <= half - 2; ++v) {
      for (int u = 2; u <= half - 2; ++u) {
        const std::size_t at = parent.index(x0 + u, y0 + v);
        if (!parent.valid[at]) continue;
        if (const auto mean = tent(picture, 2 * u + dx, 2 * v + dy)) add(sum, *mean, parent.values[at]);
      }
    }
    return sum;
  });
}

}  // namespace tintree::audit
