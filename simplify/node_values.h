#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tintree::simplify {

/// Values at a rectangle of nodes, row-major: three numbers that are filtered as they are (colours in linear light,
/// vectors), and their weight: 1, 0 where there is nothing, or what a filter made of these.
struct NodeValues {
  int width = 0;
  int height = 0;
  std::vector<std::array<float, 4>> values;

  NodeValues() = default;
  NodeValues(int across, int down)
      : width(across), height(down), values(static_cast<std::size_t>(across) * static_cast<std::size_t>(down)) {}
  const std::array<float, 4>& at(int x, int y) const { return values[index(x, y)]; }
  std::array<float, 4>& at(int x, int y) { return values[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// A symmetric filter to halve resolutions with: weights of the middle node and of those on either side of it, which
/// sum up to 1 over both sides. It has no response at the finer grid's highest frequency.
struct HalvingFilter {
  int reach = 0;
  std::array<float, 4> weights{};
};

/// Half-band filter of Lagrange type over seven nodes, maximally flat (Ansari, Guillemot and Kaiser 1991): sharp
/// pictures without much ringing.
inline constexpr HalvingFilter kSharpHalving{3, {16.0F / 32, 9.0F / 32, 0, -1.0F / 32}};
/// Tent over three nodes: no negative weight, so that means stay means.
inline constexpr HalvingFilter kMeanHalving{1, {0.5F, 0.25F}};

/// Every second node of `fine`, the first at (reach, reach), filtered along rows and along columns. What has no weight
/// counts for nothing: values are means over the rest, and weights the mean of weights. A filtered value whose weight
/// is below half means nothing.
NodeValues halve(const NodeValues& fine, const HalvingFilter& filter);

}  // namespace tintree::simplify
