#include "cache/scratch_raster.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temp_dir.h"

namespace tintree::cache {
namespace {

constexpr double kUnwritten = -12345;

/// A raster in memory that goes through the same writes.
struct Twin {
  std::int64_t columns;
  std::vector<double> values;
  double& at(std::int64_t column, std::int64_t row) { return values[static_cast<std::size_t>(row * columns + column)]; }
};

struct Rect {
  std::int64_t column, row, width, height;
};

Rect random_rect(std::mt19937& random, std::int64_t columns, std::int64_t rows) {
  const auto below = [&random](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<unsigned>(n));
  };
  const std::int64_t c = below(columns);
  const std::int64_t r = below(rows);
  return {c, r, 1 + below(columns - c), 1 + below(rows - r)};
}

void compare(const ScratchRaster& scratch, Twin& twin, const Rect& w) {
  const std::int64_t stride = w.width + 3;
  std::vector<double> got(static_cast<std::size_t>(stride * w.height), kUnwritten);
  ASSERT_TRUE(scratch.read(w.column, w.row, w.width, w.height, got.data(), stride).has_value());
  for (std::int64_t j = 0; j < w.height; ++j) {
    for (std::int64_t i = 0; i < stride; ++i) {
      const double expected = i < w.width ? twin.at(w.column + i, w.row + j) : kUnwritten;
      const double found = got[static_cast<std::size_t>(j * stride + i)];
      ASSERT_TRUE(found == expected || (std::isnan(found) && std::isnan(expected))) << i << ", " << j;
    }
  }
}

TEST(ScratchRaster, GivesBackWhatWasWrittenLast) {
  const test::TempDir dir;
  for (const ScratchSample sample : {ScratchSample::kFloat, ScratchSample::kDouble}) {
    for (const auto& [columns, rows] : {std::pair{700, 530}, {1, 600}, {512, 256}, {257, 2}, {3, 3}}) {
      std::mt19937 random(static_cast<unsigned>(columns));
      auto scratch = ScratchRaster::create(dir.path(), columns, rows, sample);
      ASSERT_TRUE(scratch.has_value()) << scratch.error().text();
      Twin twin{columns, std::vector<double>(static_cast<std::size_t>(columns * rows))};
      const auto write = [&](const Rect& w) {
        std::vector<double> values(static_cast<std::size_t>(w.width * w.height));
        for (std::int64_t j = 0; j < w.height; ++j) {
          for (std::int64_t i = 0; i < w.width; ++i) {
            double v = static_cast<double>(random()) / 7;
            if (sample == ScratchSample::kFloat) v = static_cast<double>(static_cast<float>(v));
            if (random() % 9 == 0) v = std::numeric_limits<double>::quiet_NaN();
            values[static_cast<std::size_t>(j * w.width + i)] = v;
            twin.at(w.column + i, w.row + j) = v;
          }
        }
        ASSERT_TRUE(scratch->write(w.column, w.row, w.width, w.height, values.data(), w.width).has_value());
      };
      write({0, 0, columns, rows});
      for (int i = 0; i < 8; ++i) write(random_rect(random, columns, rows));
      compare(*scratch, twin, {0, 0, columns, rows});
      for (int i = 0; i < 20; ++i) compare(*scratch, twin, random_rect(random, columns, rows));
    }
  }
}

TEST(ScratchRaster, LeavesNothingInTheFolder) {
  const test::TempDir dir;
  const auto scratch = ScratchRaster::create(dir.path(), 300, 300, ScratchSample::kFloat);
  ASSERT_TRUE(scratch.has_value());
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
}

TEST(ScratchRaster, SaysWhereItCannotBe) {
  const test::TempDir dir;
  for (const auto& scratch : {ScratchRaster::create(dir.file("nowhere"), 10, 10, ScratchSample::kFloat),
                              // An exabyte.
                              ScratchRaster::create(dir.path(), 1 << 30, 1 << 27, ScratchSample::kDouble)}) {
    ASSERT_FALSE(scratch.has_value());
    EXPECT_EQ(scratch.error().code, ErrorCode::kIo);
    EXPECT_NE(scratch.error().text().find(dir.path()), std::string::npos);
  }
}

}  // namespace
}  // namespace tintree::cache
