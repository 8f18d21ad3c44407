/// Flights with impostors against the same flights without, under OSMesa.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "render/terrain_scene.h"
#include "tests/render/analytic_tree.h"
#include "tests/render/osmesa_test.h"
#include "tests/render/seen.h"
#include "tests/support/temp_dir.h"

namespace tintree::render {
namespace {

constexpr int kWidth = 240;
constexpr int kHeight = 160;
constexpr int kFrames = 20;
/// The first picture of a slow flight is drawn over so many frames, after the one from which it moves.
constexpr int kFirst = impostor::kMostDrawing + 1;

class FarPictureTest : public OsMesaTest {
 protected:
  FarPictureTest() {
    test::AnalyticTree tree;
    tree.columns = tree.rows = 257;
    tree.tile_cells = 16;
    const std::string path = dir_.file("tree.tintree");
    tree.write(path);
    store_.emplace(std::move(*cache::TileStore::open(path)));
  }

  std::unique_ptr<TerrainScene> scene(bool impostors, std::size_t gpu_bytes = SceneOptions().gpu_bytes) const {
    SceneOptions options;
    options.impostors = impostors;
    options.gpu_bytes = gpu_bytes;
    return std::move(*TerrainScene::create(gl_, *store_, options));
  }

  static Camera camera(const glm::dvec3& eye, const glm::dvec3& target) {
    Camera c;
    c.eye = eye;
    c.target = target;
    c.width_px = kWidth;
    c.height_px = kHeight;
    return c;
  }

  struct Shot {
    Picture picture;
    DrawStats drawn;
  };
  static Shot shoot(TerrainScene& scene, const Camera& camera) {
    const auto cut = scene.settle(camera);
    EXPECT_TRUE(cut) << cut.error().text();
    const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 4);
    Style style;
    style.background = glm::vec3(1, 0, 1);
    const DrawStats drawn = scene.draw(*target, camera, *cut, style);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return {target->read_picture(), drawn};
  }

  test::TempDir dir_;
  std::optional<cache::TileStore> store_;
};

// Low over the ground with sky in sight, and high with ground all over the picture.
TEST_F(FarPictureTest, ThePictureIsTheSameWithinAPixelAndWithoutCracks) {
  for (const auto& [eye, target, step] :
       {std::tuple(glm::dvec3(200, -300, 160), glm::dvec3(2000, -1900, -100), glm::dvec3(0.03, 0.02, 0.01)),
        std::tuple(glm::dvec3(900, -700, 700), glm::dvec3(1300, -1500, 0), glm::dvec3(-0.02, 0.04, 0))}) {
    const auto with = scene(true);
    const auto without = scene(false);
    int replaced = 0, strange = 0;
    std::uint64_t drawn = 0, drawn_without = 0;
    for (int i = -kFirst; i < kFrames; ++i) {
      const glm::dvec3 moved = static_cast<double>(i) * step;
      const glm::dvec3 turned(0, 30 * std::sin(0.1 * i), 0);
      const Camera c = camera(eye + moved, target + moved + turned);
      const Shot a = shoot(*with, c);
      const Shot b = shoot(*without, c);
      if (i < 0) continue;
      replaced += a.drawn.impostor_tiles > 0 ? 1 : 0;
      drawn += a.drawn.triangles;
      drawn_without += b.drawn.triangles;
      // Other levels of detail are lit a little otherwise.
      strange += test::count_strange(a.picture, b.picture, 24);
    }
    EXPECT_EQ(replaced, kFrames);
    EXPECT_LT(drawn, drawn_without * 3 / 4);
    EXPECT_LT(strange, kFrames * kWidth * kHeight / 2000) << "of a thousand pixels half a one";
  }
}

// Of a flight so long that several are drawn: none all at once, none in vain, and each there when it is wanted.
TEST_F(FarPictureTest, IsDrawnBitByBit) {
  const auto with = scene(true);
  const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
  std::vector<std::uint64_t> parts;
  std::vector<bool> shown;
  for (int i = 0; i < 8 * impostor::kFrames; ++i) {
    const glm::dvec3 moved = static_cast<double>(i) * glm::dvec3(0.04, -0.03, 0.01);
    const Camera c = camera(glm::dvec3(200, -300, 160) + moved, glm::dvec3(2000, -1900, -100) + moved);
    const DrawStats drawn = with->draw(*target, c, *with->settle(c), {});
    parts.push_back(drawn.impostor_triangles);
    shown.push_back(drawn.impostor_tiles > 0);
  }
  const auto first = std::ranges::find(shown, true);
  ASSERT_NE(first, shown.end());
  EXPECT_LE(first - shown.begin(), kFirst);
  EXPECT_TRUE(std::all_of(first, shown.end(), [](bool s) { return s; })) << "the next was late";
  const std::uint64_t whole =
      std::accumulate(parts.begin(), parts.begin() + (first - shown.begin()) + 1, std::uint64_t{0});
  const std::uint64_t all = std::accumulate(parts.begin(), parts.end(), std::uint64_t{0});
  EXPECT_GT(all, 2 * whole) << "one lasted for all of the flight";
  EXPECT_LT(all, whole * parts.size() / impostor::kLeastDrawing / 2);
  EXPECT_LT(std::ranges::max(parts), whole / impostor::kLeastDrawing);
}

// Where it shows ground, outlines before the sky too, its depth is one that the ground has there, give or take a pixel.
TEST_F(FarPictureTest, HasTheDepthOfTheGround) {
  const auto with = scene(true);
  const auto without = scene(false);
  const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 1);
  const auto depths_m = [&](TerrainScene& scene, const Camera& c) {
    const auto cut = scene.settle(c);
    const DrawStats drawn = scene.draw(*target, c, *cut, {});
    EXPECT_EQ(drawn.impostor_tiles > 0, &scene == with.get());
    std::vector<double> out;
    for (const float d : target->read_depths()) out.push_back(d > 0 ? scene.renderer().near_m(*cut) / double{d} : 0);
    return out;
  };
  int outline = 0, amiss = 0;
  for (int frame = 0; frame < kFirst + 4; ++frame) {
    const Camera c = camera({200, -300, 160 + 0.01 * (frame - kFirst + 1)}, {2000, -1900, -100});
    if (frame < kFirst) {
      with->draw(*target, c, *with->settle(c), {});
      continue;
    }
    const auto seen = depths_m(*with, c);
    const auto plain = depths_m(*without, c);
    for (int y = 2; y < kHeight - 2; ++y) {
      for (int x = 2; x < kWidth - 2; ++x) {
        const auto at = [](int column, int row) { return static_cast<std::size_t>(row * kWidth + column); };
        if (seen[at(x, y)] == 0) continue;
        double least = 1e9, most = 0;
        bool sky = false;
        for (int k = 0; k < 25; ++k) {
          const double there = plain[at(x + k % 5 - 2, y + k / 5 - 2)];
          sky = sky || there == 0;
          if (there == 0) continue;
          least = std::min(least, there);
          most = std::max(most, there);
        }
        outline += sky ? 1 : 0;
        amiss += seen[at(x, y)] < 0.95 * least || seen[at(x, y)] > 1.05 * most ? 1 : 0;
      }
    }
  }
  EXPECT_GT(outline, kWidth / 2);
  EXPECT_EQ(amiss, 0);
}

// The picture comes out of the same memory as the tiles, which come first: what fits without it fits with it.
TEST_F(FarPictureTest, GivesWayWhereMemoryIsShort) {
  constexpr std::size_t kPictureBytes = std::size_t{8} * (kWidth * 5 / 2) * (kHeight * 5 / 2);
  std::size_t with_a_picture = 0, without_one = 0;
  for (const std::size_t budget : {std::size_t{1} << 19, std::size_t{1} << 21, std::size_t{1} << 23}) {
    const auto with = scene(true, budget);
    const auto without = scene(false, budget);
    bool replaced = false;
    for (int i = 0; i < kFirst + 3; ++i) {
      const Camera c = camera({200, -300 - 0.01 * i, 160}, {2000, -1900, -100});
      const Shot shot = shoot(*with, c);
      const Shot plain = shoot(*without, c);
      replaced = shot.drawn.impostor_tiles > 0;
      const std::size_t picture = with->frame_stats().gpu_bytes - with->pool().bytes();
      if (replaced) {
        EXPECT_TRUE(picture == kPictureBytes || picture == 2 * kPictureBytes) << picture << ": it, or the next one too";
      } else if (!without->frame_stats().gpu_memory_full) {
        EXPECT_EQ(test::count_strange(shot.picture, plain.picture, 0), 0) << budget;
      }
      EXPECT_LE(with->pool().reserved_bytes() + picture, budget);
      EXPECT_LE(with->frame_stats().gpu_memory_full, without->frame_stats().gpu_memory_full) << budget;
    }
    ++(replaced ? with_a_picture : without_one);
  }
  EXPECT_GT(with_a_picture, 0U);
  EXPECT_GT(without_one, 0U);
}

TEST_F(FarPictureTest, AFastFlightGoesWithoutOne) {
  const auto with = scene(true);
  for (int i = 0; i < 20; ++i) {
    const glm::dvec3 moved(20.0 * i, -15.0 * i, 0);
    const Shot shot = shoot(*with, camera(glm::dvec3(200, -300, 260) + moved, glm::dvec3(900, -900, 0) + moved));
    EXPECT_EQ(shot.drawn.impostor_tiles, 0U) << i;
    EXPECT_EQ(shot.drawn.impostor_triangles, 0U) << i;
  }
}

TEST_F(FarPictureTest, ChangesWithTheSun) {
  const auto with = scene(true);
  for (int i = -kFirst; i < 0; ++i) shoot(*with, camera({200, -300 + 0.01 * i, 160}, {2000, -1900, -100}));
  const Camera c = camera({200, -300, 160}, {2000, -1900, -100});
  const Shot before = shoot(*with, c);
  EXPECT_GT(before.drawn.impostor_tiles, 0U);
  const auto cut = with->settle(c);
  const auto target = OffscreenTarget::create(gl_, kWidth, kHeight, 4);
  Style evening;
  evening.background = glm::vec3(1, 0, 1);
  evening.sun_elevation_rad = 0.1;
  with->draw(*target, c, *cut, evening);
  const Picture after = target->read_picture();
  const auto without = scene(false);
  const auto plain = without->settle(c);
  without->draw(*target, c, *plain, evening);
  EXPECT_LT(test::count_strange(after, target->read_picture(), 24), kWidth * kHeight / 500);
}

}  // namespace
}  // namespace tintree::render
