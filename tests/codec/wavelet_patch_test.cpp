#include "codec/wavelet_patch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/jpeg2000_plane.h"

namespace tintree::codec {
namespace {

constexpr int kSamples = 64;
constexpr int kSide = kSamples + 2 * kPatchMargin;

/// Hills with one spike, in units of height, for layer `layer` of a pyramid (0: coarsest) at (x, y) of its patches.
Patch hills(int layer = 0, int x0 = 0, int y0 = 0) {
  Patch patch(kSide, 0);
  const double spacing = std::ldexp(1, -layer);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double u = (x0 + x - kPatchMargin + 0.5) * spacing;
      const double v = (y0 + y - kPatchMargin + 0.5) * spacing;
      const double rough = 40 * std::sin(1.9 * u) * std::cos(2.3 * v);
      patch.at(x, y) = std::llround(1000 * std::sin(0.11 * u) * std::cos(0.07 * v) + rough);
    }
  }
  return patch;
}

struct Difference {
  std::int64_t max = 0;
  double rms = 0;
};

Difference difference(const Patch& a, const Patch& b) {
  Difference out;
  for (std::size_t i = 0; i < a.heights.size(); ++i) {
    if (a.heights[i] == kNoHeight) continue;
    const std::int64_t d = std::abs(a.heights[i] - b.heights[i]);
    out.max = std::max(out.max, d);
    out.rms += static_cast<double>(d * d);
  }
  out.rms = std::sqrt(out.rms / static_cast<double>(a.heights.size()));
  return out;
}

EncodedPatch coded(const Patch& target, const Patch& prediction, const PatchSpec& spec) {
  auto patch = encode_patch(target, prediction, spec);
  EXPECT_TRUE(patch.has_value());
  std::span<const std::byte> bytes = patch->bytes;
  const auto decoded = decode_patch(bytes, prediction);
  EXPECT_TRUE(decoded.has_value()) << decoded.error().text();
  EXPECT_TRUE(bytes.empty());
  EXPECT_EQ(decoded->heights, patch->reconstruction.heights);
  return std::move(*patch);
}

TEST(WaveletPatch, ThePredictionIsBilinearBetweenTheParentsSamples) {
  const Patch parent = hills();
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const Patch child = predict_patch(parent, quadrant, 2);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        // In the parent's samples from its patch's first.
        const double u = ((quadrant & 1) * kSamples + x - kPatchMargin - 0.5) / 2 + kPatchMargin;
        const double v = ((quadrant >> 1) * kSamples + y - kPatchMargin - 0.5) / 2 + kPatchMargin;
        const int i = static_cast<int>(std::floor(u));
        const int j = static_cast<int>(std::floor(v));
        const auto at = [&](int di, int dj) { return static_cast<double>(parent.at(i + di, j + dj)); };
        const double north = std::lerp(at(0, 0), at(1, 0), u - i);
        const double south = std::lerp(at(0, 1), at(1, 1), u - i);
        ASSERT_NEAR(static_cast<double>(child.at(x, y)), 2 * std::lerp(north, south, v - j), 0.5 + 1e-9);
      }
    }
  }
}

TEST(WaveletPatch, KeepsTheCriterionInFewEncodes) {
  const Patch target = hills();
  const Patch nothing(kSide, 0);
  for (const std::int64_t bound : {2, 20, 200}) {
    const EncodedPatch max = coded(target, nothing, {.criterion = PatchCriterion::kMax, .bound = bound});
    EXPECT_LE(difference(target, max.reconstruction).max, bound);
    const EncodedPatch rms = coded(target, nothing, {.criterion = PatchCriterion::kRms, .bound = bound});
    EXPECT_LE(difference(target, rms.reconstruction).rms, static_cast<double>(bound));
    EXPECT_LE(rms.bytes.size(), max.bytes.size());
    EXPECT_LE(std::max(max.encodes, rms.encodes), 9);
    // Near the bound, or no worse than the prediction alone.
    EXPECT_GT(difference(target, rms.reconstruction).rms, 0.9 * static_cast<double>(bound));
    const EncodedPatch quick =
        coded(target, nothing, {.criterion = PatchCriterion::kRms, .bound = bound, .quick = true});
    EXPECT_LE(difference(target, quick.reconstruction).rms, static_cast<double>(bound));
    EXPECT_LE(quick.encodes, 2);
  }
}

/// The largest difference may be the bound itself over a wide range of losses: the search finds the far end of it.
TEST(WaveletPatch, TheSearchComesNearTheFewestBytes) {
  const Patch target = hills();
  const auto [low, high] = std::ranges::minmax(target.heights);
  Plane numbers{.width = kSide,
                .height = kSide,
                .bits = static_cast<int>(std::bit_width(static_cast<unsigned>(high - low))),
                .samples = {}};
  for (const std::int64_t h : target.heights) numbers.samples.push_back(static_cast<std::int32_t>(h - low));
  for (const std::int64_t bound : {1, 3, 20}) {
    std::size_t fewest = encode_plane(numbers, 0)->size();
    for (double loss = 0.1; loss < 40; loss *= 1.02) {
      const std::vector<std::byte> bytes = *encode_plane(numbers, loss);
      const Plane lossy = *decode_plane(bytes, kSide, kSide, numbers.bits);
      std::int32_t off = 0;
      for (std::size_t i = 0; i < numbers.samples.size(); ++i)
        off = std::max(off, std::abs(lossy.samples[i] - numbers.samples[i]));
      if (off <= bound) fewest = std::min(fewest, bytes.size());
    }
    const PatchSpec spec{.criterion = PatchCriterion::kMax, .bound = bound, .bits = 16};
    EXPECT_LT(coded(target, Patch(kSide, 0), spec).bytes.size(), fewest * 104 / 100) << bound;
  }
}

TEST(WaveletPatch, LiftedKeepsTheBoundInFewerBytes) {
  Patch target = hills();
  target.at(30, 30) += 5000;
  const Patch nothing(kSide, 0);
  for (const std::int64_t bound : {0, 1, 5, 25}) {
    PatchSpec spec{.criterion = PatchCriterion::kMax, .bound = bound, .bits = 16};
    const std::size_t plain = coded(target, nothing, spec).bytes.size();
    spec.lifted = true;
    const EncodedPatch lifted = coded(target, nothing, spec);
    EXPECT_LE(difference(target, lifted.reconstruction).max, bound);
    // The rougher of these hills is noise, of which without loss neither saves much.
    EXPECT_LT(lifted.bytes.size(), bound == 0 ? plain * 11 / 10 : plain * 17 / 20);
  }
}

TEST(WaveletPatch, LiftedFollowsTheFiltersOfThirdDegree) {
  // Neville filters of order 4 foretell cubic surfaces exactly: only the coarsest lattice and the sides cost bits.
  Patch cubic(kSide, 0);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) cubic.at(x, y) = 32LL * (x * x * x - 3LL * x * y * y + 40LL * x * y);
  }
  const Patch nothing(kSide, 0);
  const EncodedPatch smooth = coded(cubic, nothing, {.bound = 0, .lifted = true});
  std::mt19937 random(3);
  Patch noisy = cubic;
  for (auto& h : noisy.heights) h += random() % 2;
  const EncodedPatch rough = coded(noisy, nothing, {.bound = 0, .lifted = true});
  EXPECT_EQ(difference(noisy, rough.reconstruction).max, 0);
  // A bit of noise a sample is 578 bytes.
  EXPECT_GT(rough.bytes.size(), smooth.bytes.size() + 500);
  // Where the parent has told all already, next to nothing is left.
  EXPECT_LE(coded(noisy, noisy, {.bound = 0, .lifted = true}).bytes.size(), 24U);
}

TEST(WaveletPatch, LiftedOfEverySizeAndWithHoles) {
  std::mt19937 random(11);
  for (const int samples : {1, 2, 4, 16, 61, 128}) {
    Patch target(samples + 2 * kPatchMargin, 0);
    Patch prediction = target;
    for (std::size_t i = 0; i < target.heights.size(); ++i) {
      target.heights[i] = random() % 5 == 0 ? kNoHeight : static_cast<std::int64_t>(random() % 100000) - 50000;
      prediction.heights[i] = static_cast<std::int64_t>(random() % 1000);
    }
    const EncodedPatch patch = coded(target, prediction, {.bound = 7, .lifted = true});
    EXPECT_LE(difference(target, patch.reconstruction).max, 7) << samples;
  }
}

TEST(WaveletPatch, WithoutLossTheQuantiserAloneErrs) {
  const Patch target = hills();
  const EncodedPatch whole = coded(target, Patch(kSide, 0), {.bound = 1, .lossless = true});
  // 2^8 levels over a range of about 2000.
  EXPECT_LE(difference(target, whole.reconstruction).max, 5);
  EXPECT_EQ(whole.encodes, 1);
}

TEST(WaveletPatch, NoErrorAccumulatesDownTheLayers) {
  const PatchSpec spec{.criterion = PatchCriterion::kMax, .bound = 6};
  Patch above(kSide, 0);
  for (int layer = 0; layer < 6; ++layer) {
    const Patch target = hills(layer);
    const Patch prediction = layer == 0 ? above : predict_patch(above, 0, 1);
    above = coded(target, prediction, spec).reconstruction;
    EXPECT_LE(difference(target, above).max, spec.bound) << "layer " << layer;
  }
}

TEST(WaveletPatch, MissingHeightsCostNextToNothing) {
  Patch target(kSide, kNoHeight);
  const EncodedPatch empty = coded(target, Patch(kSide, 7), {.bound = 1});
  EXPECT_LE(empty.bytes.size(), 4U);
  EXPECT_EQ(empty.encodes, 0);
}

TEST(WaveletPatch, DamagedBytesAreRefusedOrAPatch) {
  const Patch target = hills();
  const Patch nothing(kSide, 0);
  const std::array patches{coded(target, nothing, {.bound = 5}), coded(target, nothing, {.bound = 5, .lifted = true})};
  std::mt19937 random(5);
  for (int i = 0; i < 600; ++i) {
    std::vector<std::byte> bytes = patches[static_cast<std::size_t>(i) / 300].bytes;
    bytes[random() % std::min<std::size_t>(bytes.size(), i % 2 == 0 ? 8 : bytes.size())] ^=
        static_cast<std::byte>(1 + random() % 255);
    bytes.resize(bytes.size() - random() % 3);
    std::span<const std::byte> rest = bytes;
    const auto decoded = decode_patch(rest, nothing);
    if (decoded) {
      EXPECT_EQ(decoded->heights.size(), target.heights.size());
    }
  }
}

}  // namespace
}  // namespace tintree::codec
