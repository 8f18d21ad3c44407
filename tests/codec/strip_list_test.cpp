#include "codec/strip_list.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "codec/strip_mesh.h"
#include "tests/codec/random_mesh.h"
#include "tests/codec/random_quadtree.h"

namespace tintree::codec {
namespace {

using Triangles = std::vector<std::array<std::array<std::int64_t, 3>, 3>>;

/// A list's triangles as those of a tile.
Triangles triangles_of(const StripPayload& p, const std::vector<std::uint32_t>& words) {
  const StripWords format(p);
  TileMesh mesh;
  mesh.xy_shift = p.xy_shift;
  mesh.z_offset = p.z_offset;
  for (std::size_t i = 0; i < words.size(); i += 3) {
    if (words[i] == words[i + 1]) continue;
    Triangle& t = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t w = words[i + k];
      t[k] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back({static_cast<std::int32_t>(format.x(w)) >> p.fine,
                               static_cast<std::int32_t>(format.y(w)) >> p.fine,
                               static_cast<std::int32_t>(format.height(w) << p.z_shift)});
    }
  }
  return test::triangle_set(mesh);
}

TEST(StripList, AllDecodersAgree) {
  std::mt19937 random(31);
  for (int i = 0; i < 120; ++i) {
    SCOPED_TRACE(i);
    const TileMesh mesh = test::random_quadtree(
        random, {.levels = 1 + i % 8, .splits = 3 * (i % 50), .height_range = 1 << (i % 12), .missing = i % 3 * 0.03});
    if (mesh.triangles.empty()) continue;
    const auto bytes = *StripMesh().encode(mesh);
    const StripPayload payload = *open_strip(bytes);
    ASSERT_TRUE(StripWords(payload).fit());
    std::vector<std::uint32_t> followed(3 * payload.triangles);
    std::vector<std::uint32_t> expanded(3 * payload.triangles, 7);
    follow_strip(payload, followed);
    expand_sub_strips(payload, expanded);
    EXPECT_EQ(followed, expanded);
    EXPECT_EQ(triangles_of(payload, followed), test::triangle_set(mesh));
  }
}

TEST(StripList, HangsSkirtsFromTheBorder) {
  std::mt19937 random(32);
  const TileMesh mesh = test::random_quadtree(random, {.levels = 5, .splits = 40});
  const auto bytes = *StripMesh().encode(mesh);
  const StripPayload payload = *open_strip(bytes);
  const StripWords format(payload);
  std::vector<std::uint32_t> words(3 * payload.triangles);
  follow_strip(payload, words);
  const auto skirts = strip_skirts(payload, words, whole_borders(payload.levels));
  // Two triangles a border edge; the edges' lengths add up to the outline, every vertex on it at its own place.
  std::uint32_t length = 0;
  ASSERT_EQ(skirts.size() % 6, 0U);
  for (std::size_t i = 0; i < skirts.size(); i += 6) {
    const std::uint32_t b = skirts[i];
    const std::uint32_t a = skirts[i + 1];
    EXPECT_EQ(skirts[i + 2], a | StripWords::kFoot);
    EXPECT_EQ(skirts[i + 3], b);
    EXPECT_EQ(skirts[i + 4], a | StripWords::kFoot);
    EXPECT_EQ(skirts[i + 5], b | StripWords::kFoot);
    EXPECT_TRUE(format.x(a) % 32 == 0 || format.y(a) % 32 == 0);
    const auto apart = [](std::uint32_t p, std::uint32_t q) { return p > q ? p - q : q - p; };
    length += apart(format.x(a), format.x(b)) + apart(format.y(a), format.y(b));
  }
  EXPECT_EQ(length, 4U * 32);
}

/// Of a border that lies further in, both sides have them; of none, nothing.
TEST(StripList, HangsSkirtsWhereToldTo) {
  std::mt19937 random(34);
  const auto bytes = *StripMesh().encode(test::random_quadtree(random, {.levels = 5, .splits = 40}));
  const StripPayload payload = *open_strip(bytes);
  const StripWords format(payload);
  std::vector<std::uint32_t> words(3 * payload.triangles);
  follow_strip(payload, words);
  EXPECT_TRUE(strip_skirts(payload, words, {-1, -1, -1, -1}).empty());
  for (const std::uint32_t word : strip_skirts(payload, words, {-1, -1, -1, 32})) EXPECT_EQ(format.y(word), 32U);
  std::uint32_t length = 0;
  const auto skirts = strip_skirts(payload, words, {0, -1, -1, -1});
  for (std::size_t i = 0; i < skirts.size(); i += 6) {
    EXPECT_EQ(format.x(skirts[i]), 0U);
    length += format.y(skirts[i]) > format.y(skirts[i + 1]) ? format.y(skirts[i]) - format.y(skirts[i + 1])
                                                            : format.y(skirts[i + 1]) - format.y(skirts[i]);
  }
  EXPECT_EQ(length, 32U);
}

TEST(StripList, KnowsWhatDoesNotFit) {
  StripPayload p;
  p.levels = 9;
  p.height_bits = 11;
  EXPECT_TRUE(StripWords(p).fit());
  EXPECT_TRUE(unpacks_on_card(p));
  p.height_bits = 12;
  EXPECT_FALSE(StripWords(p).fit());
  EXPECT_FALSE(unpacks_on_card(p));
  p.levels = 11;  // Words would have room, headers have not.
  p.height_bits = 7;
  EXPECT_TRUE(StripWords(p).fit());
  EXPECT_FALSE(unpacks_on_card(p));
}

TEST(StripList, StaysInsideItsWordsOnDamage) {
  std::mt19937 random(33);
  const auto bytes = *StripMesh().encode(test::random_quadtree(random, {.levels = 6, .splits = 60}));
  for (int i = 0; i < 500; ++i) {
    auto damaged = bytes;
    for (int k = 0; k < 9; ++k) damaged[8 + random() % (damaged.size() - 8)] = static_cast<std::byte>(random());
    const auto payload = open_strip(damaged);
    if (!payload || !StripWords(*payload).fit()) continue;
    std::vector<std::uint32_t> words(3 * payload->triangles);
    follow_strip(*payload, words);
    expand_sub_strips(*payload, words);
  }
}

}  // namespace
}  // namespace tintree::codec
