#include "core/math/rotation_error.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_rotation_error {
namespace {

Quat turn(Real angle, const Vec3& axis) {
  const Real s = std::sin(angle / 2);
  return Quat(std::cos(angle / 2), s * axis.x(), s * axis.y(), s * axis.z());
}

TEST(RotationErrorTo, LeadsTheBodyOntoTheTarget) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const Quat q_WB = random.rotation(), q_WD = random.rotation();
    const Vec3 phi_B = rotation_error(q_WB, q_WD, random.vector()).phi_B;
    const Quat reached = q_WB * turn(phi_B.norm(), phi_B.normalized());
    EXPECT_NEAR(std::abs(reached.dot(q_WD)), 1, 1e-14);
    EXPECT_LE(phi_B.norm(), pi + 0.11);
  }
}

TEST(RotationErrorTo, GoesTheShorterWayAndKnowsNoSignOfQuaternions) {
  const Quat q(1, 0, 0, 0);
  const Vec3 axis(0.6, 0, 0.8);
  for (const Real angle : {0.0, 1e-9, 0.5, 2.0, 3.0}) {
    for (const Real sign : {1.0, -1.0}) {
      Quat target = turn(angle, axis);
      target.coeffs() *= sign;
      EXPECT_LE((rotation_error(q, target, Vec3::Zero()).phi_B - angle * axis).norm(), 1e-14);
      EXPECT_LE((rotation_error(target, q, Vec3::Zero()).phi_B + angle * axis).norm(), 1e-14);
    }
  }
  EXPECT_LE((rotation_error(q, turn(4, axis), Vec3::Zero()).phi_B - (4 - 2 * pi) * axis).norm(), 1e-14);
}

TEST(RotationErrorTo, CurvatureIsThatOfTheLogarithmUntilItPassesOneHalf) {
  EXPECT_NEAR(rotation_error(Quat::Identity(), Quat::Identity(), Vec3::Zero()).curvature, 1.0 / 12, 1e-7);
  for (Real angle = 0.1; angle < 2.31; angle += 0.01) {
    const Real c = rotation_error(Quat::Identity(), turn(angle, Vec3::UnitX()), Vec3::Zero()).curvature;
    EXPECT_NEAR(c * angle * angle, 1 - angle / 2 / std::tan(angle / 2), 1e-6) << angle;
  }
  for (Real angle = 2.31; angle < pi + 0.1; angle += 0.01) {
    const Real c = rotation_error(Quat::Identity(), turn(angle, Vec3::UnitX()), Vec3::UnitX()).curvature;
    EXPECT_LE(c * angle * angle, 0.5) << angle;
    EXPECT_GT(c * angle * angle, 0) << angle;
  }
}

TEST(RotationErrorTo, KeepsItsSideThroughTheHalfTurnAndChangesItOnce) {
  const Vec3 axis = Vec3(1, 2, 2) / 3;
  Vec3 previous = Vec3::Zero();
  int changes = 0;
  for (Real angle = 2.9; angle < 3.5; angle += 1e-3) {
    const Vec3 phi_B = rotation_error(Quat::Identity(), turn(angle, axis), previous).phi_B;
    if (previous.dot(phi_B) < 0) {
      ++changes;
      EXPECT_NEAR(angle, pi + 0.1, 2e-3);
    } else {
      EXPECT_LE((phi_B - angle * axis).norm() * (changes == 0), 1e-13) << angle;
    }
    previous = phi_B;
  }
  EXPECT_EQ(changes, 1);
}

TEST(RotationErrorTo, DoesNotChatterWhenHeldAtTheHalfTurn) {
  Random random(2);
  const Vec3 axis = random.direction();
  for (const Vec3& first : {Vec3(axis), Vec3(-axis)}) {
    Vec3 previous = 3 * first;
    for (int i = 0; i < 10000; ++i) {
      const Vec3 tremor = 1e-3 * random.vector();
      const Quat target = turn(pi, axis) * turn(tremor.norm(), tremor.normalized());
      const Vec3 phi_B = rotation_error(Quat::Identity(), target, previous).phi_B;
      ASSERT_TRUE(phi_B.allFinite());
      ASSERT_GT(phi_B.dot(first), 3);
      previous = phi_B;
    }
  }
}

TEST(RotationErrorTo, IsFiniteEverywhereNearTheHalfTurn) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const Real angle = pi + random.uniform(-1, 1) * random.log_uniform(1e-18, 1e-1);
    const Quat q_WD = turn(angle, random.direction());
    const RotationError error = rotation_error(Quat::Identity(), q_WD, Vec3::Zero());
    ASSERT_TRUE(error.phi_B.allFinite());
    ASSERT_NEAR(error.phi_B.norm(), pi, 0.11);
    ASSERT_LE(error.curvature * error.phi_B.squaredNorm(), 0.5);
  }
}

}  // namespace
}  // namespace godobject::test_rotation_error
