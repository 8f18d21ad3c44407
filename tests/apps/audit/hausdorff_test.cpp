#include "apps/audit/hausdorff.h"

#include <gtest/gtest.h>

namespace tintree::test {
namespace {

audit::TriangleSoup square(double z) {
  return {{{{{0, 0, z}, {1, 0, z}, {1, 1, z}}}, {{{0, 0, z}, {1, 1, z}, {0, 1, z}}}}};
}

TEST(Hausdorff, OfParallelSquares) { EXPECT_NEAR(audit::symmetric_hausdorff(square(0), square(2), 0.01), 2, 0.011); }

TEST(Hausdorff, IsSymmetric) {
  const audit::TriangleSoup large{{{{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}}}}};
  const audit::TriangleSoup small{{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}};
  const double there = audit::symmetric_hausdorff(large, small, 0.01);
  EXPECT_NEAR(there, audit::symmetric_hausdorff(small, large, 0.01), 0.02);
  EXPECT_NEAR(there, 8.5, 0.6);
}

TEST(Hausdorff, IsAtMostTheErrorBoundForEqualSurfaces) {
  EXPECT_LE(audit::symmetric_hausdorff(square(1), square(1), 0.1), 0.1);
}

}  // namespace
}  // namespace tintree::test
