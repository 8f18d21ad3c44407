#include "simplify/reference_surface.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/simplify/support.h"
#include "tests/support/temp_dir.h"

namespace tintree::simplify {
namespace {

using test::Terrain;

TEST(ReferenceSurface, CountsSamplesAndRanges) {
  const Terrain terrain = test::make_terrain(513, 257, [](int c, int r) {
    return c >= 256 && r > 20 ? test::kMissing : c < 256 ? 5.0 + r : -7.0;
  });
  std::uint64_t valid = 0;
  for (const double h : terrain.grid.heights_m) valid += std::isnan(h) ? 0 : 1;
  EXPECT_EQ(terrain.surface->valid_samples(), valid);
  EXPECT_EQ(terrain.surface->height_range_m({0, 0, 10, 10}), (std::array<double, 2>{-7, 261}));
  EXPECT_EQ(terrain.surface->height_range_m({300, 0, 310, 10}), (std::array<double, 2>{-7, -7}));
  EXPECT_EQ(terrain.surface->height_range_m({0, 0, 512, 256}), (std::array<double, 2>{-7, 261}));
  const auto none = terrain.surface->height_range_m({10, 10, 10, 10});
  EXPECT_GT(none[0], none[1]);
}

TEST(ReferenceSurface, HasNoRangeWhereNothingIs) {
  const Terrain terrain = test::make_terrain(513, 20, [](int c, int) { return c > 255 ? test::kMissing : 1.0; });
  const auto range = terrain.surface->height_range_m({256, 0, 512, 19});
  EXPECT_GT(range[0], range[1]);
}

TEST(ReferenceSurface, KnowsWhetherThereIsAnyTriangle) {
  const auto has_surface = [](const test::HeightFunction& height) {
    return test::make_terrain(300, 280, height).surface->has_surface();
  };
  EXPECT_TRUE(has_surface([](int, int) { return 1.0; }));
  EXPECT_FALSE(has_surface([](int c, int) { return c % 2 == 0 ? 1.0 : test::kMissing; }));
  // Three samples, without and with the diagonal from north-west to south-east.
  EXPECT_FALSE(has_surface([](int c, int r) { return c + r <= 1 ? 1.0 : test::kMissing; }));
  EXPECT_TRUE(has_surface(
      [](int c, int r) { return (c == 299 || c == 298) && (r == 279 || c + r == 576) ? 1.0 : test::kMissing; }));
}

TEST(ReferenceSurface, DigestChangesWithEverySample) {
  const auto digest = [](int column, int row, double by) {
    return test::make_terrain(300, 40,
                              [=](int c, int r) { return test::hills(c, r) + (c == column && r == row ? by : 0); })
        .surface->digest();
  };
  const std::string plain = digest(-1, -1, 0);
  EXPECT_EQ(plain.size(), 32U);
  EXPECT_EQ(digest(-1, -1, 0), plain);
  for (const auto& [c, r] : {std::pair{0, 0}, {299, 39}, {299, 0}, {256, 20}, {255, 1}, {17, 39}}) {
    EXPECT_NE(digest(c, r, 1.0 / 64), plain) << c << ' ' << r;
    EXPECT_NE(digest(c, r, test::kMissing), plain) << c << ' ' << r;
  }
}

TEST(ReferenceSurface, DigestTellsAWholeShiftInHeight) {
  const auto digest = [](double up) {
    return test::make_terrain(40, 40, [=](int c, int r) { return test::hills(c, r) + up; }).surface->digest();
  };
  EXPECT_NE(digest(0), digest(1));
}

TEST(ReferenceSurface, ScanStopsWhenAsked) {
  const Terrain terrain = test::make_terrain(600, 600, [](int, int) { return 1.0; });
  const auto blocks = std::shared_ptr<cache::HeightBlocks>(&terrain.surface->blocks(), [](auto*) {});
  std::uint64_t seen = 0;
  const auto stopped = ReferenceSurface::scan(blocks, [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(total, 9U);
    seen = done;
    return done < 3;
  });
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, ErrorCode::kStopped);
  EXPECT_EQ(seen, 3U);
}

TEST(ReferenceSurface, KeepsThePyramidInAFileWhereItDoesNotFit) {
  const Terrain terrain = test::make_terrain(1500, 1300, test::rough_hills(20, 3, 0.05));
  const auto blocks = std::shared_ptr<cache::HeightBlocks>(&terrain.surface->blocks(), [](auto*) {});
  const test::TempDir dir;
  const auto on = [](std::uint64_t, std::uint64_t) { return true; };
  const auto paged = ReferenceSurface::scan(blocks, on, {65536, dir.path()});
  ASSERT_TRUE(paged.has_value()) << paged.error().text();
  EXPECT_TRUE(std::filesystem::is_empty(dir.path())) << "the file has no name";
  EXPECT_EQ((*paged)->digest(), terrain.surface->digest());
  for (int round = 0; round < 500; ++round) {
    const auto bx = static_cast<std::int64_t>(test::noise(round, 1) * 6);
    const auto by = static_cast<std::int64_t>(test::noise(round, 2) * 6);
    const BlockPatches& expected = terrain.surface->patches(bx, by);
    EXPECT_EQ(std::memcmp(&(*paged)->patches(bx, by), &expected, sizeof expected), 0) << bx << ' ' << by;
  }
  const auto nowhere = ReferenceSurface::scan(blocks, on, {65536, dir.file("missing")});
  ASSERT_FALSE(nowhere.has_value());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kIo);
}

TEST(SurfaceView, GivesEverySampleWhateverTheOrder) {
  const Terrain terrain = test::make_terrain(600, 300, test::rough_hills(20, 3, 0.05));
  SurfaceView view(*terrain.surface);
  for (int k = 0; k < 20000; ++k) {
    const auto column = static_cast<std::int64_t>(test::noise(k, 1) * 604) - 2;
    const auto row = static_cast<std::int64_t>(test::noise(k, 2) * 304) - 2;
    const double found = view.sample(column, row);
    const double expected = terrain.grid.at(column, row);
    EXPECT_TRUE(found == expected || (std::isnan(found) && std::isnan(expected))) << column << ' ' << row;
  }
}

}  // namespace
}  // namespace tintree::simplify
