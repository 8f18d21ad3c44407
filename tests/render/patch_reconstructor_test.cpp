// Patches and normals made by shaders, under OSMesa, against the processor's own and against analysis.
#include "render/patch_reconstructor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/wavelet_tiles.h"
#include "tests/render/osmesa_test.h"

namespace tintree::render {
namespace {

using cache::make_tile_relief;
using cache::TileRelief;
using codec::kPatchMargin;
using codec::Patch;

constexpr int kCells = 16;
constexpr int kSide = kCells + 2 * kPatchMargin;
constexpr int kNodes = kCells + 1;

class PatchReconstructorTest : public OsMesaTest {
 protected:
  void SetUp() override {
    auto made = PatchReconstructor::create(gl_);
    ASSERT_TRUE(made) << made.error().text();
    reconstructor_ = std::move(*made);
  }

  template <typename T>
  static std::vector<T> read(GLuint texture, int size, int channels, GLenum format, GLenum type) {
    GLuint framebuffer = 0;
    gl_.GenFramebuffers(1, &framebuffer);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    EXPECT_EQ(gl_.CheckFramebufferStatus(GL_FRAMEBUFFER), static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
    std::vector<T> out(static_cast<std::size_t>(size * size * channels));
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.ReadPixels(0, 0, size, size, format, type, out.data());
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl_.DeleteFramebuffers(1, &framebuffer);
    EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR));
    return out;
  }
  static std::vector<std::int64_t> heights(GLuint texture) {
    const auto values = read<std::int32_t>(texture, kSide, 1, GL_RED_INTEGER, GL_INT);
    return {values.begin(), values.end()};
  }
  static std::vector<float> normals(GLuint texture) { return read<float>(texture, kNodes, 2, GL_RG, GL_FLOAT); }

  std::unique_ptr<PatchReconstructor> reconstructor_;
};

codec::TreeLayout layout_of(std::int64_t columns, std::int64_t rows) {
  codec::TreeLayout layout;
  layout.columns = columns;
  layout.rows = rows;
  layout.tile_cells = kCells;
  layout.leaf_level = codec::TreeLayout::leaf_level_for(columns, rows, kCells);
  layout.dx_m = 2.5;
  layout.dy_m = 3;
  for (int level = 0; level <= layout.leaf_level; ++level)
    layout.z_step_m.push_back(std::ldexp(0.125, layout.leaf_level - level));
  return layout;
}

/// A mesh over the rectangle of samples [0, east] x [0, south] of a leaf.
codec::TileMesh rectangle(std::int32_t east, std::int32_t south, int shift = 0) {
  codec::TileMesh mesh;
  mesh.xy_shift = shift;
  mesh.vertices = {{0, 0, 0}, {east, 0, 0}, {0, south, 0}, {east, south, 0}};
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}};
  return mesh;
}

Patch random_patch(std::mt19937& random, std::int64_t low, std::int64_t high) {
  std::uniform_int_distribution<std::int64_t> height(low, high);
  Patch out(kSide, 0);
  for (std::int64_t& h : out.heights) h = height(random);
  return out;
}

/// Parents of any heights, children near to what they foretell: few levels, many, coarse steps, none.
TEST_F(PatchReconstructorTest, MakesTheSamePatchesAsTheProcessor) {
  const codec::TreeLayout layout = layout_of(64, 64);
  std::mt19937 random(7);
  constexpr std::int64_t kMost = codec::kFarthestOnCard - 70000;
  const std::array<std::array<std::int64_t, 2>, 4> ranges{
      {{-9, 9}, {-5000, 8000}, {kMost / 2 - 60000, kMost / 2}, {-kMost / 2, -kMost / 2 + 60000}}};
  for (std::size_t i = 0; i < 32; ++i) {
    SCOPED_TRACE(i);
    const auto [low, high] = ranges[i % ranges.size()];
    const Patch root = random_patch(random, low, high);
    const auto root_residual = codec::make_patch_residual(root, Patch(kSide, 0));
    ASSERT_TRUE(root_residual.has_value());
    const TileRelief above = make_tile_relief(layout, {0, 0, 0}, rectangle(16, 16, 2), *root_residual);
    const GLuint parent = reconstructor_->make_heights(above, 0);
    EXPECT_EQ(heights(parent), root.heights);
    const codec::TileId id{1, static_cast<std::uint32_t>(i / 4 % 2), static_cast<std::uint32_t>(i / 8 % 2)};
    const Patch prediction = codec::wavelet_prediction(layout, id, &root);
    const std::int64_t step = std::array<std::int64_t, 4>{0, 1, 3, 250}[i / 4 % 4];
    Patch child = random_patch(random, 0, i % 2 == 0 ? 200 : 256);
    for (std::size_t k = 0; k < child.heights.size(); ++k)
      child.heights[k] = prediction.heights[k] + 17 - step * child.heights[k];
    const auto residual = codec::make_patch_residual(child, prediction);
    ASSERT_TRUE(residual.has_value());
    EXPECT_EQ(residual->numbers.empty(), step == 0 || (i % 2 == 1 && !residual->wide_numbers.empty()));
    const TileRelief relief = make_tile_relief(layout, id, rectangle(16, 16, 1), *residual);
    const GLuint made = reconstructor_->make_heights(relief, parent);
    EXPECT_EQ(heights(made), child.heights);
    for (const GLuint texture : {parent, made}) gl_.DeleteTextures(1, &texture);
  }
}

TEST_F(PatchReconstructorTest, WhatACardsIntegersDoNotHoldIsLeftOut) {
  const Patch flat(kSide, 0);
  Patch high = flat;
  high.at(3, 4) = codec::kFarthestOnCard;
  EXPECT_FALSE(codec::make_patch_residual(high, flat).has_value());
  EXPECT_FALSE(codec::make_patch_residual(flat, high).has_value());
  Patch fine = flat;
  fine.at(3, 4) = 65535;
  EXPECT_TRUE(codec::make_patch_residual(fine, flat).has_value());
  fine.at(0, 0) = 65536;
  EXPECT_FALSE(codec::make_patch_residual(fine, flat).has_value());
}

/// Heights in metres over metres east and north of the DEM's first sample.
using Surface = std::function<double(double, double)>;

/// A tile's patch of samples of a surface, in units of its level: central differences and the means between samples
/// give a quadratic's slopes exactly, but for the rounding to units, of which there are a few a spacing.
Patch patch_of(const codec::TreeLayout& layout, const codec::TileId& id, const Surface& surface) {
  Patch out(kSide, 0);
  const int shift = layout.leaf_level - id.level;
  const double unit_m = layout.z_step_m[static_cast<std::size_t>(id.level)] / codec::kUnitsAStep;
  const auto place = [&](std::uint32_t tile, int i) {
    return std::ldexp(static_cast<double>(tile) * kCells + i - kPatchMargin + 0.5, shift) - 0.5;
  };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto [east, north] = layout.world(place(id.x, x), place(id.y, y));
      out.at(x, y) = std::llround(surface(east, north) / unit_m);
    }
  }
  return out;
}

std::array<double, 2> normal_of(double slope_east, double slope_north) {
  const double length = std::sqrt(1 + slope_east * slope_east + slope_north * slope_north);
  return {-slope_east / length, -slope_north / length};
}

TEST_F(PatchReconstructorTest, NormalsAreThoseOfTheSurface) {
  codec::TreeLayout layout = layout_of(64, 64);
  const Surface surface = [](double x, double y) {
    return 0.6 * x - 0.3 * y + 0.004 * x * x - 0.006 * x * y + 0.003 * y * y;
  };
  for (const bool rotated : {false, true}) {
    if (rotated) layout.axes = {{0.6, 0.8}, {0.8, -0.6}};
    for (const codec::TileId id : {codec::TileId{0, 0, 0}, {1, 1, 0}, {2, 2, 3}}) {
      SCOPED_TRACE(id.text());
      const auto residual = codec::make_patch_residual(patch_of(layout, id, surface), Patch(kSide, 0));
      ASSERT_TRUE(residual.has_value());
      const int shift = layout.leaf_level - id.level;
      TileRelief relief = make_tile_relief(layout, id, rectangle(16, 16, shift), *residual);
      relief.on_raster = {0, 0, kSide - 1, kSide - 1};
      relief.parent.reset();
      const GpuRelief made = reconstructor_->make(relief, 0);
      EXPECT_EQ(made.heights != 0, id.level < layout.leaf_level);
      const auto got = normals(made.normals);
      double worst = 0;
      for (int y = 0; y < kNodes; ++y) {
        for (int x = 0; x < kNodes; ++x) {
          const auto [east, north] = layout.world(std::ldexp(static_cast<double>(id.x) * kCells + x, shift),
                                                  std::ldexp(static_cast<double>(id.y) * kCells + y, shift));
          const auto want = normal_of(0.6 + 0.008 * east - 0.006 * north, -0.3 - 0.006 * east + 0.006 * north);
          const auto at = static_cast<std::size_t>(2 * (y * kNodes + x));
          for (std::size_t k = 0; k < 2; ++k)
            worst = std::max(worst, std::abs(static_cast<double>(got[at + k]) - want[k]));
        }
      }
      // Half a unit (16 mm at the leaves) over 2.5 m is the rounding of the heights.
      EXPECT_LT(worst, 1.0 / 128);
      destroy(gl_, made);
    }
  }
}

/// What the shader has to do, in plain words: NormalLayer's differences, over samples that are there.
std::array<double, 2> expected_leaf_normal(const TileRelief& relief, const Patch& patch, int node_x, int node_y) {
  const auto there = [&](int x, int y) {
    const auto& [west, north, east, south] = relief.on_raster;
    if (x < west || y < north || x > east || y > south) return false;
    return relief.surface.empty() || relief.surface[patch.index(x, y)] != 0;
  };
  const auto slope = [&](int x, int y, int dx, int dy) {
    const bool before = there(x - dx, y - dy);
    const bool after = there(x + dx, y + dy);
    const auto high = static_cast<double>(patch.at(after ? x + dx : x, after ? y + dy : y));
    const auto low = static_cast<double>(patch.at(before ? x - dx : x, before ? y - dy : y));
    return before || after ? (high - low) / (before && after ? 2 : 1) : std::numeric_limits<double>::quiet_NaN();
  };
  const auto gather = [&](int reach, int ahead) {
    std::array<double, 3> sum{};
    for (int y = node_y + kPatchMargin - reach; y <= node_y + kPatchMargin + ahead; ++y) {
      for (int x = node_x + kPatchMargin - reach; x <= node_x + kPatchMargin + ahead; ++x) {
        if (!there(x, y)) continue;
        const double across = slope(x, y, 1, 0);
        const double down = slope(x, y, 0, 1);
        if (std::isnan(across) || std::isnan(down)) continue;
        sum = {sum[0] + across, sum[1] + down, sum[2] + 1};
      }
    }
    return sum;
  };
  auto sum = gather(0, 0);
  if (sum[2] == 0) sum = gather(2, 1);
  if (sum[2] == 0) return {0, 0};
  const double across = sum[0] / sum[2];
  const double down = sum[1] / sum[2];
  const auto& m = relief.slopes;
  return normal_of(static_cast<double>(m[0]) * across + static_cast<double>(m[2]) * down,
                   static_cast<double>(m[1]) * across + static_cast<double>(m[3]) * down);
}

TEST_F(PatchReconstructorTest, NothingIsTakenFromHolesOrFromBeyondTheRaster) {
  const codec::TreeLayout layout = layout_of(26, 30);
  std::mt19937 random(3);
  for (const codec::TileId id : {codec::TileId{1, 0, 0}, {1, 1, 1}}) {
    for (const bool holes : {false, true}) {
      SCOPED_TRACE(id.text());
      const Patch patch = random_patch(random, -300, 300);
      const auto residual = codec::make_patch_residual(patch, Patch(kSide, 0));
      const codec::CellRect cells = layout.cells(id);
      const auto east = static_cast<std::int32_t>(cells.column1 - cells.column0);
      const auto south = static_cast<std::int32_t>(cells.row1 - cells.row0);
      TileRelief relief = make_tile_relief(layout, id, rectangle(holes ? 5 : east, holes ? 6 : south), *residual);
      EXPECT_EQ(relief.surface.empty(), !holes);
      relief.parent.reset();
      const GpuRelief made = reconstructor_->make(relief, 0);
      const auto got = normals(made.normals);
      for (int y = 0; y < kNodes; ++y) {
        for (int x = 0; x < kNodes; ++x) {
          const auto want = expected_leaf_normal(relief, patch, x, y);
          const auto at = static_cast<std::size_t>(2 * (y * kNodes + x));
          for (std::size_t k = 0; k < 2; ++k)
            ASSERT_NEAR(static_cast<double>(got[at + k]), want[k], 1e-3) << x << " " << y;
        }
      }
      destroy(gl_, made);
    }
  }
}

TEST_F(PatchReconstructorTest, WithoutItsParentsHeightsATileHasNoRelief) {
  const codec::TreeLayout layout = layout_of(64, 64);
  const auto residual = codec::make_patch_residual(Patch(kSide, 5), Patch(kSide, 0));
  const TileRelief relief = make_tile_relief(layout, {1, 0, 0}, rectangle(16, 16, 1), *residual);
  const GpuRelief made = reconstructor_->make(relief, 0);
  EXPECT_EQ(made.normals, 0U);
  EXPECT_EQ(made.bytes, 0U);
}

}  // namespace
}  // namespace tintree::render
