// Strips decoded by shaders, under OSMesa, against the decoders on the processor.
#include "render/strip_decoder.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "codec/strip_list.h"
#include "codec/strip_mesh.h"
#include "render/offscreen_target.h"
#include "tests/codec/random_quadtree.h"
#include "tests/render/osmesa_test.h"

namespace tintree::render {
namespace {

using codec::StripPayload;

using Words = std::vector<std::uint32_t>;

/// Skirts, six words each, in ascending order.
std::vector<std::array<std::uint32_t, 6>> sorted(const Words& skirts) {
  std::vector<std::array<std::uint32_t, 6>> out(skirts.size() / 6);
  for (std::size_t i = 0; i < skirts.size(); ++i) out[i / 6][i % 6] = skirts[i];
  std::ranges::sort(out);
  return out;
}

class StripDecoderTest : public OsMesaTest, public testing::WithParamInterface<StripDecoder::Path> {};

TEST_P(StripDecoderTest, GivesTheSameTrianglesAsTheProcessor) {
  const auto decoder = StripDecoder::create(gl_, GetParam());
  ASSERT_TRUE(decoder) << decoder.error().text();
  std::mt19937 random(41);
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    const codec::TileMesh mesh = test::random_quadtree(
        random, {.levels = 1 + i % 9, .splits = 20 * (i % 7), .height_range = 1 << (i % 10), .missing = i % 3 * 0.02});
    if (mesh.triangles.empty()) continue;
    const auto bytes = *codec::StripMesh().encode(mesh);
    const StripPayload payload = *codec::open_strip(bytes);
    Words expected(3 * payload.triangles);
    codec::follow_strip(payload, expected);
    const Words skirts = codec::strip_skirts(payload, expected);
    const auto words = decoder->decode(payload);
    ASSERT_TRUE(words) << words.error().text();
    EXPECT_EQ(words->read(0, words->triangle_words), expected);
    ASSERT_EQ(words->skirt_words, skirts.size());
    const Words got = words->read(words->triangle_words, words->skirt_words);
    EXPECT_EQ(sorted(got), sorted(skirts));
    if (GetParam() == StripDecoder::Path::kFeedback) {
      EXPECT_EQ(got, skirts);
    }
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
  }
}

TEST_P(StripDecoderTest, RefusesWhatDoesNotFitIntoWords) {
  const auto decoder = StripDecoder::create(gl_, GetParam());
  ASSERT_TRUE(decoder) << decoder.error().text();
  std::mt19937 random(42);
  for (const test::QuadtreeSpec& spec :
       {test::QuadtreeSpec{.levels = 11, .splits = 8}, {.levels = 9, .splits = 30, .height_range = 4095}}) {
    const auto bytes = *codec::StripMesh().encode(test::random_quadtree(random, spec));
    EXPECT_FALSE(decoder->decode(*codec::open_strip(bytes)));
  }
}

TEST_P(StripDecoderTest, DrawsFromTheIndexBufferAlone) {
  const auto decoder = StripDecoder::create(gl_, GetParam());
  const auto drawer = StripDrawer::create(gl_);
  ASSERT_TRUE(decoder && drawer);
  std::mt19937 random(43);
  codec::TileMesh mesh = test::random_quadtree(random, {.levels = 4, .splits = 30});
  // A slope, so that what lies between vertices is known: from black in the west to white in the east.
  for (codec::GridVertex& v : mesh.vertices) v.z = v.x * 16 - (v.x == 16 ? 1 : 0);
  const auto bytes = *codec::StripMesh().encode(mesh);
  const StripPayload payload = *codec::open_strip(bytes);
  const auto words = decoder->decode(payload);
  ASSERT_TRUE(words);
  constexpr int kSide = 128;
  auto target = OffscreenTarget::create(gl_, kSide, kSide, 1);
  ASSERT_TRUE(target);
  target->bind();
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_FRAMEBUFFER_SRGB);
  gl_.ClearColor(1, 0, 0, 1);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  // From above, the tile fills the picture; skirts stand on edge.
  const float step = 2.0F / 16;
  drawer->draw(*words, payload, {step, 0, 0, 0, 0, -step, 0, 0, 0, 0, 0, 0, -1, 1, 0, 1}, 3);
  const Picture picture = target->read_picture();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto rgb = picture.at(x, y);
      ASSERT_NEAR(rgb[0], 256.0 * (x + 0.5) / kSide, 3) << x << ' ' << y;
      ASSERT_EQ(rgb[0], rgb[1]) << x << ' ' << y;
    }
  }
  EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
}

INSTANTIATE_TEST_SUITE_P(Paths, StripDecoderTest,
                         testing::Values(StripDecoder::Path::kCompute, StripDecoder::Path::kFeedback),
                         [](const auto& path) {
                           return path.param == StripDecoder::Path::kCompute ? "Compute" : "Feedback";
                         });

}  // namespace
}  // namespace tintree::render
