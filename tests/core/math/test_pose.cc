#include "core/math/pose.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_pose {
namespace {

Pose random_pose(Random& random) {
  const Vec3 p = random.uniform(0, 3) * random.direction();
  return {.p = p, .q = exp_so3(random.uniform(0, pi) * random.direction())};
}

Eigen::Isometry3d isometry(const Pose& X) { return Eigen::Translation3d(X.p) * X.q; }

TEST(Pose, ProductsAndInverseAreThoseOfTheirMatrices) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose X_AB = random_pose(random), X_BC = random_pose(random);
    const Vec3 p_C = random.direction();
    EXPECT_TRUE(isometry(X_AB * X_BC).isApprox(isometry(X_AB) * isometry(X_BC), 1e-14));
    EXPECT_LE((X_AB * (X_BC * p_C) - isometry(X_AB) * (isometry(X_BC) * p_C)).norm(), 1e-14);
    EXPECT_LE(((X_AB * X_BC) * p_C - X_AB * (X_BC * p_C)).norm(), 1e-14);
    EXPECT_TRUE(isometry(inverse(X_AB)).isApprox(isometry(X_AB).inverse(), 1e-14));
    EXPECT_LE((inverse(X_AB) * (X_AB * p_C) - p_C).norm(), 1e-14);
  }
}

TEST(Pose, LongProductsStayPoses) {
  Random random(4);
  Pose X;
  for (int i = 0; i < 100'000; ++i) X = X * Pose{.p = Vec3::Zero(), .q = exp_so3(random.direction())};
  EXPECT_NEAR(X.q.norm(), 1, 1e-14);
}

}  // namespace
}  // namespace godobject::test_pose
