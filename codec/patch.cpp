#include "codec/patch.h"

namespace tintree::codec {

Patch predict_patch(const Patch& parent, int quadrant, int units) {
  const int n = parent.side - 2 * kPatchMargin;
  Patch out(parent.side, 0);
  // A sample lies a quarter of the parent's spacing off the nearer of the two that it is between.
  const auto near = [&](int i, int half) { return (i + half + kPatchMargin) >> 1; };
  const int east = (quadrant & 1) * n;
  const int south = (quadrant >> 1) * n;
  for (int y = 0; y < out.side; ++y) {
    const int y0 = near(y, south);
    const int y1 = y0 + (((y + south) & 1) == 0 ? -1 : 1);
    for (int x = 0; x < out.side; ++x) {
      const int x0 = near(x, east);
      const int x1 = x0 + (((x + east) & 1) == 0 ? -1 : 1);
      const std::int64_t sum =
          9 * parent.at(x0, y0) + 3 * parent.at(x1, y0) + 3 * parent.at(x0, y1) + parent.at(x1, y1);
      out.at(x, y) = (sum * units + 8) >> 4;
    }
  }
  return out;
}

}  // namespace tintree::codec
