#include "render/gpu_pages.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/render/osmesa_test.h"

namespace tintree::render {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::size_t kUnitsInMiB = kMiB / GpuPages::kUnit;

class GpuPagesTest : public OsMesaTest {};

TEST_F(GpuPagesTest, RangesOfAPageAreApartAndUsedAgain) {
  GpuPages pages(gl_, 8 * kMiB);
  std::vector<PageRange> ranges;
  while (const auto range = pages.take(1000)) ranges.push_back(*range);
  EXPECT_EQ(pages.count(), 8U);
  EXPECT_GT(ranges.size(), 8 * (kUnitsInMiB / 1000 - 1));
  EXPECT_LE(pages.reserved_bytes(), 8 * kMiB);
  for (const PageRange& a : ranges) {
    EXPECT_LE((a.begin + a.length) * GpuPages::kUnit, pages.page(a).bytes);
    EXPECT_EQ(std::ranges::count_if(ranges,
                                    [&a](const PageRange& b) {
                                      return a.page == b.page && a.begin < b.begin + b.length &&
                                             b.begin < a.begin + a.length;
                                    }),
              1);
  }
  const PageRange back = ranges[ranges.size() / 2];
  pages.give_back(back);
  const auto again = pages.take(1000);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->page, back.page);
  EXPECT_EQ(again->begin, back.begin);
}

TEST_F(GpuPagesTest, ALongRangeHasALargerPage) {
  GpuPages pages(gl_, 8 * kMiB);
  const auto range = pages.take(3 * kUnitsInMiB);
  ASSERT_TRUE(range);
  EXPECT_EQ(range->bytes(), 3 * kUnitsInMiB * GpuPages::kUnit);
  const std::uint32_t last = 7;
  const auto at = static_cast<GLintptr>(range->begin * GpuPages::kUnit + range->bytes() - sizeof(last));
  gl_.BindBuffer(GL_ARRAY_BUFFER, pages.page(*range).buffer);
  gl_.BufferSubData(GL_ARRAY_BUFFER, at, sizeof(last), &last);
  EXPECT_EQ(gl_.GetError(), static_cast<GLenum>(GL_NO_ERROR)) << "the buffer is as long";
  EXPECT_FALSE(pages.take(6 * kUnitsInMiB)) << "more than what is left";
  EXPECT_FALSE(pages.take(9 * kUnitsInMiB)) << "more than the budget";
}

TEST_F(GpuPagesTest, WhatIsSetAsideStaysFree) {
  GpuPages pages(gl_, 4 * kMiB);
  ASSERT_TRUE(pages.set_aside(3 * kMiB));
  ASSERT_TRUE(pages.take(kUnitsInMiB));
  EXPECT_FALSE(pages.take(kUnitsInMiB));
  ASSERT_TRUE(pages.set_aside(0));
  const auto second = pages.take(kUnitsInMiB);
  ASSERT_TRUE(second);
  EXPECT_FALSE(pages.set_aside(3 * kMiB));
  EXPECT_EQ(pages.find_page({true, true}), std::nullopt);
  ASSERT_EQ(pages.find_page({true, false}), second->page);
  pages.give_back(*second);
  pages.drop(second->page);
  EXPECT_EQ(pages.find_page({true, false}), std::nullopt) << "a dropped page has no buffer";
  EXPECT_TRUE(pages.set_aside(3 * kMiB));
  EXPECT_FALSE(pages.take(kUnitsInMiB));
  ASSERT_TRUE(pages.set_aside(0));
  EXPECT_EQ(pages.take(kUnitsInMiB)->page, second->page);
  EXPECT_LE(pages.reserved_bytes(), 4 * kMiB);
}

}  // namespace
}  // namespace tintree::render
