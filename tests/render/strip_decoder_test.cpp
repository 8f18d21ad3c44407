// Strips decoded by shaders, under OSMesa, against the decoders on the processor.
#include "render/strip_decoder.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/strip_list.h"
#include "codec/strip_mesh.h"
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

constexpr std::uint32_t kUntouched = 0xabcdef01;

class StripDecoderTest : public OsMesaTest, public testing::WithParamInterface<StripDecoder::Path> {
 protected:
  void TearDown() override {
    for (const GLuint buffer : buffers_) gl_.DeleteBuffers(1, &buffer);
  }
  GLuint make_buffer(std::size_t words) {
    const Words values(words, kUntouched);
    gl_.GenBuffers(1, &buffers_.emplace_back());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_.back());
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * words), values.data(), GL_DYNAMIC_COPY);
    return buffers_.back();
  }
  static Words read(GLuint buffer, std::size_t first, std::size_t count) {
    Words out(count);
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffer);
    gl_.GetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(4 * first), static_cast<GLsizeiptr>(4 * count),
                         out.data());
    return out;
  }

 private:
  std::vector<GLuint> buffers_;
};

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
    codec::StripBorders borders = codec::whole_borders(payload.levels);
    // Now and then without one, or further in.
    if (i % 4 == 1) borders[static_cast<std::size_t>(i / 4 % 4)] = i % 3 == 0 ? -1 : 1 << payload.levels >> 1;
    const Words skirts = codec::strip_skirts(payload, expected, borders);
    // Somewhere in a buffer, where nothing else is to be touched.
    const StripRange range{make_buffer(expected.size() + skirts.size() + 12), 5,
                           static_cast<std::uint32_t>(expected.size()), static_cast<std::uint32_t>(skirts.size())};
    const auto decoded = decoder->decode(payload, borders, range);
    ASSERT_TRUE(decoded) << decoded.error().text();
    EXPECT_EQ(read(range.buffer, 0, 5), Words(5, kUntouched));
    EXPECT_EQ(read(range.buffer, 5, expected.size()), expected);
    const Words got = read(range.buffer, 5 + expected.size(), skirts.size());
    EXPECT_EQ(read(range.buffer, 5 + expected.size() + skirts.size(), 7), Words(7, kUntouched));
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
    EXPECT_FALSE(decoder->decode(*codec::open_strip(bytes), codec::whole_borders(9), {}));
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, StripDecoderTest,
                         testing::Values(StripDecoder::Path::kCompute, StripDecoder::Path::kFeedback),
                         [](const auto& path) {
                           return path.param == StripDecoder::Path::kCompute ? "Compute" : "Feedback";
                         });

}  // namespace
}  // namespace tintree::render
