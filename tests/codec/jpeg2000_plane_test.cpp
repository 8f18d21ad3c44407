#include "codec/jpeg2000_plane.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

namespace tintree::codec {
namespace {

/// Waves, and a little that no wavelet foretells.
Plane waves(int width, int height, int bits) {
  Plane plane{width, height, bits, {}};
  const double top = std::ldexp(1, bits) - 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = 0.5 + 0.45 * std::sin(0.05 * x) * std::cos(0.07 * y);
      const double grain = 0.04 * ((x * 7919 + y * 104729) % 17) / 17.0;
      plane.samples.push_back(static_cast<std::int32_t>(std::min(top, top * (wave + grain))));
    }
  }
  return plane;
}

double rms(const Plane& a, const Plane& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i) sum += std::pow(a.samples[i] - b.samples[i], 2);
  return std::sqrt(sum / static_cast<double>(a.samples.size()));
}

TEST(Jpeg2000Plane, WithoutALimitEverySampleComesBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, {12, 12}, {37, 5}, {260, 260}}) {
    for (const int bits : {1, 8, 12, 16}) {
      const Plane plane = waves(width, height, bits);
      const auto stream = encode_plane(plane, 0);
      ASSERT_TRUE(stream.has_value()) << stream.error().text();
      const auto decoded = decode_plane(*stream, width, height, bits);
      ASSERT_TRUE(decoded.has_value()) << decoded.error().text();
      EXPECT_EQ(decoded->samples, plane.samples) << width << " x " << height << ", " << bits << " bits";
    }
  }
}

TEST(Jpeg2000Plane, LosesAboutWhatItMay) {
  const Plane plane = waves(260, 260, 8);
  std::size_t last = 0;
  for (const double loss : {8.0, 4.0, 2.0, 1.0}) {
    const auto stream = encode_plane(plane, loss);
    ASSERT_TRUE(stream.has_value());
    EXPECT_GT(stream->size(), last);
    last = stream->size();
    const auto decoded = decode_plane(*stream, 260, 260, 8);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_NEAR(rms(plane, *decoded), loss, 0.3 * loss);
  }
  EXPECT_LT(last, encode_plane(plane, 0)->size());
}

TEST(Jpeg2000Plane, RefusesOrSurvivesWhatIsNoStream) {
  const Plane plane = waves(68, 68, 8);
  const auto stream = encode_plane(plane, 0);
  ASSERT_TRUE(stream.has_value());
  for (std::size_t i = 0; i < stream->size(); i += 7) {
    std::vector<std::byte> damaged = *stream;
    damaged[i] ^= std::byte{0x5a};
    static_cast<void>(decode_plane(damaged, 68, 68, 8));
    static_cast<void>(decode_plane(std::span(*stream).first(i), 68, 68, 8));
  }
}

}  // namespace
}  // namespace tintree::codec
