#include "core/stage.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/core/one_body.h"

namespace godobject::test_stage {
namespace {

TEST(Stage, Solve3MatchesEigen) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    Mat3 A;
    for (Real& a : A.reshaped()) a = random.normal();
    const Vec3 b = random.vector();
    const Vec3 x = solve3(A, b);
    const Real condition = A.norm() * A.inverse().norm();
    ASSERT_LE((x - A.inverse() * b).norm(), 1e-15 * condition * condition * x.norm());
    ASSERT_LE((A * x - b).norm(), 1e-15 * condition * condition * b.norm());
  }
}

/// J of (11): how the error shrinks when the body turns, by central differences.
TEST(Stage, DerivativeOfTheRotationErrorMatchesDifferences) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Quat q_WB = random.rotation();
    const Quat q_WD = q_WB * exp_so3(random.uniform(0, 2.3) * random.direction());
    const RotationError error = rotation_error(q_WB, q_WD, Vec3::Zero());
    const Mat3 phi_cross = skew(error.phi_B);
    const Mat3 J = Mat3::Identity() - 0.5 * phi_cross + error.curvature * phi_cross * phi_cross;
    for (int axis = 0; axis < 3; ++axis) {
      const Real d = 1e-5;
      const Vec3 xi = d * Vec3::Unit(axis);
      const Vec3 ahead = rotation_error(q_WB * exp_so3(xi), q_WD, Vec3::Zero()).phi_B;
      const Vec3 behind = rotation_error(q_WB * exp_so3(-xi), q_WD, Vec3::Zero()).phi_B;
      ASSERT_LE((J.col(axis) + (ahead - behind) / (2 * d)).norm(), 2e-6) << error.phi_B.norm();
    }
  }
}

/// (10) holds for the velocity found, forces taken at the end.
TEST(Stage, TranslationSolvesItsEquation) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Real m = random.log_uniform(1e-3, 1e2), h = random.log_uniform(1e-5, 1e-2);
    const SpringParams s{.k = random.log_uniform(1, 1e6), .g = random.log_uniform(1e-2, 1e3)};
    const Vec3 v = random.vector(), e = random.vector(), v_D = random.vector(), F = random.vector();
    const TranslationSystem system = implicit_translation(m, s, v, e, v_D, F, h);
    const Vec3 v_new = system.b_W / system.M;
    const Vec3 force = F + s.g * (v_D - v_new) + s.k * (e - h * v_new);
    const Real size = m * (v.norm() + v_new.norm()) + h * (F.norm() + s.g * v_D.norm() + s.k * e.norm());
    ASSERT_LE((m * (v_new - v) - h * force).norm(), 1e-14 * size);
  }
}

/// For small steps, (11) is Euler's equation with (2): I w' = T_B + g_r (w_D - w) + k_r phi - w x I w.
TEST(Stage, RotationAcceleratesAsEulersEquationSays) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const RigidBodyParams body = rigid_body(1, random.inertia(Vec3(1, 2, 4)));
    const SpringParams s{.k_r = random.uniform(0, 10), .g_r = random.uniform(0, 2)};
    const Vec3 w = random.vector(), w_D = random.vector(), T = random.vector();
    const RotationError error = rotation_error(Quat::Identity(), random.rotation(), Vec3::Zero());
    const Real h = 1e-7;
    const RotationSystem system = implicit_rotation(body, s, w, error, w_D, T, h);
    const Vec3 acceleration = (solve3(system.A_B, system.b_B) - w) / h;
    const Vec3 torque = T + s.g_r * (w_D - w) + s.k_r * error.phi_B - w.cross(body.I_B * w);
    ASSERT_LE((acceleration - body.I_B.inverse() * torque).norm(), 1e-4);
  }
}

TEST(Stage, QuaternionStaysOfUnitLength) {
  Random random(5);
  Pose X;
  Real worst = 0;
  for (int i = 0; i < 1000000; ++i) {
    X = moved(X, Vec3::Zero(), random.vector() * random.uniform(0, 1e3), 1e-3);
    worst = std::max(worst, std::abs(X.q.norm() - 1));
  }
  EXPECT_LE(worst, 1e-15);
}

TEST(Stage, NoBodyTurnsMoreThanHalfATurnInAStep) {
  const Pose X = moved(Pose{}, Vec3(1, 2, 3), Vec3(0, 1e6, 0), 1e-3);
  EXPECT_NEAR(std::abs(X.q.y()), 1, 1e-15);
  EXPECT_LE((X.p - Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-18);
}

}  // namespace
}  // namespace godobject::test_stage
