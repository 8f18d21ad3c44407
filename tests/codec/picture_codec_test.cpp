#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "codec/normal_codec.h"
#include "codec/texture_codec.h"

namespace tintree::codec {
namespace {

ColorImage landscape(int size, bool holes) {
  ColorImage image(size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double v = 128 + 70 * std::sin(x / 6.0) * std::cos(y / 9.0) + 8 * std::sin(x * 1.7 + y * 2.3);
      std::uint8_t* t = image.at(x, y);
      t[0] = static_cast<std::uint8_t>(v);
      t[1] = static_cast<std::uint8_t>(0.8 * v + 20);
      t[2] = static_cast<std::uint8_t>(200 - v / 2);
      t[3] = holes && x + 2 * y < size ? 0 : 255;
    }
  }
  return image;
}

double psnr(const ColorImage& a, const ColorImage& b) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3 || a.rgba[i - i % 4 + 3] == 0) continue;
    sum += std::pow(static_cast<double>(a.rgba[i]) - b.rgba[i], 2);
    ++count;
  }
  return 10 * std::log10(255 * 255 * count / std::max(sum, 1e-9));
}

class TextureCodecTest : public testing::TestWithParam<const char*> {
 protected:
  const TextureCodec& codec() const { return *find_texture_codec(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(All, TextureCodecTest, testing::Values("bc1", "jpeg"));

TEST_P(TextureCodecTest, GivesBackThePicture) {
  for (const int size : {2, 17, 64, 129}) {
    for (const bool holes : {false, true}) {
      const ColorImage image = landscape(size, holes);
      const auto payload = codec().encode(image);
      ASSERT_TRUE(payload.has_value());
      const auto decoded = codec().decode(*payload, size);
      ASSERT_TRUE(decoded.has_value()) << decoded.error().text();
      ASSERT_EQ(decoded->size, size);
      for (std::size_t i = 3; i < image.rgba.size(); i += 4) ASSERT_EQ(decoded->rgba[i], image.rgba[i]) << i;
      // Tiny pictures are nearly all edge.
      EXPECT_GT(psnr(image, *decoded), size < 17 ? 20 : 30) << size << holes;
      EXPECT_EQ(*codec().encode(image), *payload);
    }
  }
}

TEST_P(TextureCodecTest, PixelsAreThePayloadsOwn) {
  const auto payload = codec().encode(landscape(33, true));
  const auto pixels = codec().pixels(*payload, 33);
  ASSERT_TRUE(pixels.has_value());
  EXPECT_EQ(pixels->size, 33);
  EXPECT_EQ(pixels->bytes.size(), pixels->format == PixelFormat::kBc1 ? 9 * 9 * 8U : 33 * 33 * 4U);
}

TEST_P(TextureCodecTest, RefusesWhatIsNoPictureOfTheSize) {
  const auto payload = codec().encode(landscape(33, true));
  ASSERT_TRUE(payload.has_value());
  EXPECT_FALSE(codec().decode(*payload, 65).has_value());
  EXPECT_FALSE(codec().decode({}, 33).has_value());
  std::vector<std::byte> version = *payload;
  version[0] = std::byte{7};
  EXPECT_FALSE(codec().decode(version, 33).has_value());
  const std::span<const std::byte> whole(*payload);
  for (std::size_t n = 1; n < 140; ++n) EXPECT_FALSE(codec().decode(whole.first(n), 33).has_value()) << n;
}

TEST(TextureCodec, IsNullForAnUnknownName) { EXPECT_EQ(find_texture_codec("webp"), nullptr); }

NormalImage hills(int size, bool rough) {
  NormalImage image(size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double east = 0.6 * std::sin(x / 8.0);
      const double north = 0.5 * std::cos(y / 11.0);
      const double length = rough ? 0.75 + 0.25 * std::sin((x - y) / 13.0) : 1;
      image.at(x, y) = {static_cast<float>(length * east), static_cast<float>(length * north),
                        static_cast<float>(length * std::sqrt(1 - east * east - north * north))};
    }
  }
  return image;
}

TEST(NormalCodec, GivesBackDirectionsAndLengths) {
  for (const bool rough : {false, true}) {
    const NormalImage image = hills(65, rough);
    const auto payload = encode_normals(image);
    EXPECT_EQ(payload.size(), 1 + 17 * 17 * (rough ? 24U : 16U));
    const auto decoded = decode_normals(payload, 65);
    ASSERT_TRUE(decoded.has_value());
    for (std::size_t i = 0; i < image.vectors.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(decoded->vectors[i][k], image.vectors[i][k], 0.03) << i;
    }
  }
}

TEST(NormalCodec, KeepsLevelGroundExactly) {
  NormalImage image(5);
  for (auto& v : image.vectors) v = {0, 0, 1};
  const auto decoded = decode_normals(encode_normals(image), 5);
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(decoded->vectors, image.vectors);
}

TEST(NormalCodec, NeverGivesMoreThanUnitLength) {
  NormalImage image(4);
  for (std::size_t i = 0; i < 16; ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / 16;
    image.vectors[i] = {static_cast<float>(std::cos(turn)), static_cast<float>(std::sin(turn)), 0};
  }
  const auto decoded = decode_normals(encode_normals(image), 4);
  ASSERT_TRUE(decoded.has_value());
  for (const auto& v : decoded->vectors) EXPECT_LT(std::hypot(v[0], v[1], v[2]), 1 + 1e-5);
}

TEST(NormalCodec, RefusesWhatIsNoNormalMapOfTheSize) {
  const auto payload = encode_normals(hills(9, true));
  EXPECT_FALSE(decode_normals(payload, 33).has_value());
  for (std::size_t n = 0; n < payload.size(); ++n) {
    EXPECT_FALSE(decode_normals(std::span(payload).first(n), 9).has_value()) << n;
  }
}

}  // namespace
}  // namespace tintree::codec
