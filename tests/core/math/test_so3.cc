#include "core/math/so3.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_so3 {
namespace {

TEST(So3, ExponentialMatchesSineAndCosineUpToHalfATurn) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const Real angle = i == 0 ? pi : random.uniform(0, pi);
    const Vec3 u = random.direction();
    const Quat q = exp_so3(angle * u);
    EXPECT_NEAR(q.w(), std::cos(angle / 2), 1e-15);
    EXPECT_LE((q.vec() - std::sin(angle / 2) * u).norm(), 1e-15);
    EXPECT_NEAR(q.norm(), 1, 1e-15);
  }
}

TEST(So3, ExponentialOfNothingIsTheIdentity) {
  const Quat q = exp_so3(Vec3::Zero());
  EXPECT_EQ(q.w(), 1);
  EXPECT_EQ(q.vec(), Vec3(Vec3::Zero()));
}

TEST(So3, SmallTurnsKeepTheirRelativePrecision) {
  for (Real angle = 1e-300; angle < 1e-2; angle *= 10) {
    const Quat q = exp_so3(Vec3(0, angle, 0));
    EXPECT_NEAR(q.y() / std::sin(angle / 2), 1, 1e-15) << angle;
  }
}

TEST(So3, LogFactorMatchesArcCosine) {
  // From half a turn and 0.1 rad more down to nothing.
  for (Real w = -0.06; w < 0.999; w += 1e-4) {
    const Real alpha = 2 * std::acos(w);
    EXPECT_NEAR(log_factor(w) / (alpha / std::sin(alpha / 2)), 1, 3e-15) << w;
  }
  EXPECT_EQ(log_factor(1), 2);
}

TEST(So3, LogarithmInvertsTheExponential) {
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = random.uniform(0, pi) * random.direction();
    const Quat q = exp_so3(a);
    EXPECT_LE((log_factor(q.w()) * q.vec() - a).norm(), 4e-15);
  }
}

TEST(So3, RotationsOfVectorsMatchEigen) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Quat q = random.rotation();
    const Vec3 a = random.vector();
    EXPECT_LE((to_world(q, a) - q.toRotationMatrix() * a).norm(), 4e-15 * a.norm());
    EXPECT_LE((to_body(q, a) - q.toRotationMatrix().transpose() * a).norm(), 4e-15 * a.norm());
    const Vec3 b = random.vector();
    EXPECT_LE((skew(a) * b - a.cross(b)).norm(), 1e-15 * a.norm() * b.norm());
  }
}

TEST(So3, TurnFromZIsTheShortest) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 u = random.direction();
    const Quat q = turn_from_z(random.uniform(0.1, 10) * u);
    const Real rounding = 1e-15 / (1 + u.z());  // remaining digits of z.u
    EXPECT_LE((to_world(q, Vec3::UnitZ()) - u).norm(), 4 * rounding);
    EXPECT_NEAR(q.norm(), 1, rounding);
    EXPECT_EQ(q.z(), 0);  // nothing about z itself
    EXPECT_NEAR(q.w(), std::sqrt((1 + u.z()) / 2), rounding);
  }
  EXPECT_EQ(turn_from_z(Vec3::UnitZ()).vec(), Vec3(Vec3::Zero()));
  EXPECT_EQ(to_world(turn_from_z(Vec3(0, 0, -2)), Vec3::UnitZ()), Vec3(0, 0, -1));
}

TEST(So3, RenormalisingIsExactForRoundingErrors) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    Quat q = random.rotation();
    q.coeffs() *= 1 + random.uniform(-1e-8, 1e-8);
    EXPECT_NEAR(renormalized(q).norm(), 1, 5e-16);
  }
}

}  // namespace
}  // namespace godobject::test_so3
