#include "core/body/target.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_target {
namespace {

/// A smooth motion about a fixed axis and along a curve, with its exact velocity.
Target motion(Real t) {
  const Vec3 u(0.36, 0.48, 0.8);
  const Real angle = std::sin(3 * t) + 0.5 * t;
  const Real s = std::sin(angle / 2);
  return {.X_WD = {.p = Vec3(std::sin(2 * t), std::cos(3 * t), t * t),
                   .q = Quat(std::cos(angle / 2), s * u.x(), s * u.y(), s * u.z())},
          .V_WD = {.w = (3 * std::cos(3 * t) + 0.5) * u,
                   .v = Vec3(2 * std::cos(2 * t), -3 * std::sin(3 * t), 2 * t)}};
}

struct Error {
  Real p = 0, q = 0, v = 0, w = 0;
};

/// Worst error between samples h apart.
Error worst_error(Real h) {
  Error worst;
  for (Real t = 0; t < 2; t += h)
    for (const Real s : {0.25, 0.5, 0.58578643762690497}) {
      const Target x = interpolated(motion(t), motion(t + h), s, h), y = motion(t + s * h);
      worst.p = std::max(worst.p, (x.X_WD.p - y.X_WD.p).norm());
      worst.q = std::max(worst.q, (x.X_WD.q.coeffs() - y.X_WD.q.coeffs()).norm());
      worst.v = std::max(worst.v, (x.V_WD.v - y.V_WD.v).norm());
      worst.w = std::max(worst.w, (x.V_WD.w - y.V_WD.w).norm());
    }
  return worst;
}

TEST(TargetBetweenSamples, IsOfFourthOrderInThePoseThirdInVelocitySecondInTurningRate) {
  const Error coarse = worst_error(0.02), fine = worst_error(0.005);
  const auto order = [](Real a, Real b) { return std::log2(a / b) / 2; };
  EXPECT_GE(order(coarse.p, fine.p), 3.9);
  EXPECT_GE(order(coarse.q, fine.q), 3.9);
  EXPECT_GE(order(coarse.v, fine.v), 2.9);
  EXPECT_GE(order(coarse.w, fine.w), 1.9);
}

TEST(TargetBetweenSamples, IsTheSampleAtBothEnds) {
  const Target a = motion(0.3), b = motion(0.31);
  for (const Real s : {0.0, 1.0}) {
    const Target x = interpolated(a, b, s, 0.01), &y = s == 0 ? a : b;
    EXPECT_LE((x.X_WD.p - y.X_WD.p).norm(), 1e-15);
    EXPECT_LE((x.X_WD.q.coeffs() - y.X_WD.q.coeffs()).norm(), 1e-15);
    EXPECT_LE((x.V_WD.v - y.V_WD.v).norm(), 1e-13);
    EXPECT_LE((x.V_WD.w - y.V_WD.w).norm(), 1e-13);
  }
}

TEST(TargetBetweenSamples, IsUnitAndFiniteHoweverFarApartTheSamplesAre) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    Target a{.X_WD = {.p = random.vector(), .q = random.rotation()},
             .V_WD = {.w = random.log_uniform(1e-3, 1e3) * random.direction(), .v = random.vector()}};
    Target b = a;
    b.X_WD.q = random.rotation();
    if (a.X_WD.q.dot(b.X_WD.q) < 0) b.X_WD.q.coeffs() *= -1;
    const Target x = interpolated(a, b, random.uniform(0, 1), random.log_uniform(1e-5, 5e-2));
    ASSERT_NEAR(x.X_WD.q.norm(), 1, 1e-15);
    ASSERT_TRUE(x.X_WD.p.allFinite() && x.V_WD.v.allFinite() && x.V_WD.w.allFinite());
  }
}

}  // namespace
}  // namespace godobject::test_target
