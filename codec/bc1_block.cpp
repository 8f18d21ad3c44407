#include "codec/bc1_block.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace tintree::codec {
namespace {

using Color = std::array<float, 3>;
using Rgb = std::array<int, 3>;

constexpr int kCovered = 128;

Rgb expand(std::uint16_t packed) {
  const int r = packed >> 11;
  const int g = (packed >> 5) & 63;
  const int b = packed & 31;
  return {(r << 3) | (r >> 2), (g << 2) | (g >> 4), (b << 3) | (b >> 2)};
}

int quantised(float v, int most) {
  return std::clamp(static_cast<int>(std::lround(v * static_cast<float>(most) / 255.0F)), 0, most);
}

std::uint16_t pack(const Color& c) {
  return static_cast<std::uint16_t>((quantised(c[0], 31) << 11) | (quantised(c[1], 63) << 5) | quantised(c[2], 31));
}

/// The colours that a block offers; the fourth of the three-colour mode means "not covered".
std::array<Rgb, 4> palette(std::uint16_t c0, std::uint16_t c1) {
  const Rgb a = expand(c0);
  const Rgb b = expand(c1);
  std::array<Rgb, 4> out{a, b, Rgb{}, Rgb{}};
  for (std::size_t k = 0; k < 3; ++k) {
    if (c0 > c1) {
      out[2][k] = (2 * a[k] + b[k] + 1) / 3;
      out[3][k] = (a[k] + 2 * b[k] + 1) / 3;
    } else {
      out[2][k] = (a[k] + b[k]) / 2;
    }
  }
  return out;
}

/// For every value of a channel the ends whose point at one third comes nearest to it.
struct ThirdTable {
  std::array<std::array<std::uint8_t, 2>, 256> ends{};

  explicit ThirdTable(int most) {
    const auto full = [most](int v) { return most == 31 ? (v << 3) | (v >> 2) : (v << 2) | (v >> 4); };
    for (int value = 0; value < 256; ++value) {
      int least = std::numeric_limits<int>::max();
      for (int a = 0; a <= most; ++a) {
        for (int b = 0; b <= most; ++b) {
          const int error = 256 * std::abs((2 * full(a) + full(b) + 1) / 3 - value) + std::abs(a - b);
          if (error >= least) continue;
          least = error;
          ends[static_cast<std::size_t>(value)] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
        }
      }
    }
  }
};

/// A block being fitted.
struct Fit {
  std::uint16_t c0 = 0;
  std::uint16_t c1 = 0;
  std::array<std::uint8_t, 16> choice{};
  int error = std::numeric_limits<int>::max();
};

class Fitter {
 public:
  explicit Fitter(const ColorBlock& texels) : texels_(texels) {
    for (std::size_t i = 0; i < 16; ++i) {
      if (texels[i][3] >= kCovered) covered_[count_++] = i;
    }
  }

  Bc1Block fit() {
    const bool holes = count_ < 16;
    Fit best;
    if (count_ > 0) {
      const auto [low, high] = ends_along_axis();
      best = choose(low, high, holes);
      for (int pass = 0; pass < 2 && best.error > 0; ++pass) {
        const auto refined = refine(best, holes);
        if (!refined || refined->error >= best.error) break;
        best = *refined;
      }
    }
    if (!holes && best.error > 0 && is_plain()) best = plain(best);
    if (holes) mark_holes(best);
    return written(best);
  }

 private:
  struct Ends {
    Color low;
    Color high;
  };

  Ends ends_along_axis() const {
    Color mean{};
    for (std::size_t n = 0; n < count_; ++n) {
      for (std::size_t k = 0; k < 3; ++k) mean[k] += texels_[covered_[n]][k];
    }
    for (float& m : mean) m /= static_cast<float>(count_);
    std::array<float, 6> cov{};  // rr rg rb gg gb bb
    for (std::size_t n = 0; n < count_; ++n) {
      const Color d = off(covered_[n], mean);
      cov[0] += d[0] * d[0];
      cov[1] += d[0] * d[1];
      cov[2] += d[0] * d[2];
      cov[3] += d[1] * d[1];
      cov[4] += d[1] * d[2];
      cov[5] += d[2] * d[2];
    }
    Color axis{0.299F, 0.587F, 0.114F};
    for (int step = 0; step < 6; ++step) {
      const Color next{cov[0] * axis[0] + cov[1] * axis[1] + cov[2] * axis[2],
                       cov[1] * axis[0] + cov[3] * axis[1] + cov[4] * axis[2],
                       cov[2] * axis[0] + cov[4] * axis[1] + cov[5] * axis[2]};
      const float most = std::max({std::abs(next[0]), std::abs(next[1]), std::abs(next[2])});
      if (most < 1e-6F) break;
      for (std::size_t k = 0; k < 3; ++k) axis[k] = next[k] / most;
    }
    const float square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    float least = 0;
    float most = 0;
    for (std::size_t n = 0; n < count_; ++n) {
      const Color d = off(covered_[n], mean);
      const float along = (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]) / square;
      least = std::min(least, along);
      most = std::max(most, along);
    }
    Ends ends{mean, mean};
    for (std::size_t k = 0; k < 3; ++k) {
      ends.low[k] += least * axis[k];
      ends.high[k] += most * axis[k];
    }
    return ends;
  }

  bool is_plain() const {
    return std::ranges::all_of(texels_, [this](const auto& t) { return t == texels_[0]; });
  }

  /// A block of one colour, where two thirds of one end and one of the other come nearer than either.
  Fit plain(const Fit& before) const {
    static const ThirdTable fives(31);
    static const ThirdTable sixes(63);
    const auto ends = [this](std::size_t end) {
      const auto& t = texels_[0];
      return static_cast<std::uint16_t>((fives.ends[t[0]][end] << 11) | (sixes.ends[t[1]][end] << 5) |
                                        fives.ends[t[2]][end]);
    };
    Fit fit{ends(0), ends(1), {}, 0};
    if (fit.c0 == fit.c1) return before;
    fit.choice.fill(2);
    if (fit.c0 < fit.c1) {
      std::swap(fit.c0, fit.c1);
      fit.choice.fill(3);
    }
    return fit;
  }

  Color off(std::size_t i, const Color& mean) const {
    const auto& t = texels_[i];
    return {static_cast<float>(t[0]) - mean[0], static_cast<float>(t[1]) - mean[1], static_cast<float>(t[2]) - mean[2]};
  }

  /// The best choice of colours between two ends.
  Fit choose(const Color& low, const Color& high, bool holes) const {
    Fit fit{pack(high), pack(low), {}, 0};
    // The order of the two says whether there are four colours or three and none.
    if ((fit.c0 > fit.c1) == holes) std::swap(fit.c0, fit.c1);
    const std::array<Rgb, 4> colors = palette(fit.c0, fit.c1);
    const int offered = fit.c0 > fit.c1 ? 4 : 3;
    for (std::size_t n = 0; n < count_; ++n) {
      const auto& t = texels_[covered_[n]];
      int least = std::numeric_limits<int>::max();
      for (int p = 0; p < offered; ++p) {
        const Rgb& c = colors[static_cast<std::size_t>(p)];
        const int r = t[0] - c[0];
        const int g = t[1] - c[1];
        const int b = t[2] - c[2];
        const int error = r * r + g * g + b * b;
        if (error >= least) continue;
        least = error;
        fit.choice[covered_[n]] = static_cast<std::uint8_t>(p);
      }
      fit.error += least;
    }
    return fit;
  }

  /// The ends that suit the choices best, and the choices that suit those.
  std::optional<Fit> refine(const Fit& fit, bool holes) const {
    constexpr std::array<float, 4> kFour{1, 0, 2.0F / 3, 1.0F / 3};
    constexpr std::array<float, 4> kThree{1, 0, 0.5F, 0};
    const auto& shares = fit.c0 > fit.c1 ? kFour : kThree;
    float aa = 0;
    float ab = 0;
    float bb = 0;
    Color at{};
    Color bt{};
    for (std::size_t n = 0; n < count_; ++n) {
      const float a = shares[fit.choice[covered_[n]]];
      const float b = 1 - a;
      aa += a * a;
      ab += a * b;
      bb += b * b;
      for (std::size_t k = 0; k < 3; ++k) {
        at[k] += a * texels_[covered_[n]][k];
        bt[k] += b * texels_[covered_[n]][k];
      }
    }
    const float det = aa * bb - ab * ab;
    if (det < 1e-4F) return std::nullopt;
    Color first{};
    Color second{};
    for (std::size_t k = 0; k < 3; ++k) {
      first[k] = (at[k] * bb - bt[k] * ab) / det;
      second[k] = (bt[k] * aa - at[k] * ab) / det;
    }
    return choose(second, first, holes);
  }

  void mark_holes(Fit& fit) const {
    for (std::size_t i = 0; i < 16; ++i) {
      if (texels_[i][3] < kCovered) fit.choice[i] = 3;
    }
  }

  static Bc1Block written(const Fit& fit) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 16; ++i) bits |= std::uint32_t{fit.choice[i]} << (2 * i);
    Bc1Block out{};
    const auto byte = [](std::uint32_t v) { return static_cast<std::byte>(v & 255U); };
    out[0] = byte(fit.c0);
    out[1] = byte(fit.c0 >> 8U);
    out[2] = byte(fit.c1);
    out[3] = byte(fit.c1 >> 8U);
    for (std::size_t k = 0; k < 4; ++k) out[4 + k] = byte(bits >> (8 * k));
    return out;
  }

  const ColorBlock& texels_;
  std::array<std::size_t, 16> covered_{};
  std::size_t count_ = 0;
};

}  // namespace

Bc1Block encode_bc1(const ColorBlock& texels) { return Fitter(texels).fit(); }

ColorBlock decode_bc1(const Bc1Block& block) {
  const auto at = [&block](std::size_t i) { return std::to_integer<std::uint32_t>(block[i]); };
  const auto c0 = static_cast<std::uint16_t>(at(0) | at(1) << 8U);
  const auto c1 = static_cast<std::uint16_t>(at(2) | at(3) << 8U);
  const std::array<Rgb, 4> colors = palette(c0, c1);
  const bool holes = c0 <= c1;
  ColorBlock out{};
  for (std::size_t i = 0; i < 16; ++i) {
    const std::uint32_t choice = (at(4 + i / 4) >> (2 * (i % 4))) & 3U;
    for (std::size_t k = 0; k < 3; ++k) out[i][k] = static_cast<std::uint8_t>(colors[choice][k]);
    out[i][3] = holes && choice == 3 ? 0 : 255;
  }
  return out;
}

}  // namespace tintree::codec
