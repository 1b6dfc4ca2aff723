#include "tests/oracle/extrapolation.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace godobject::oracle::test_extrapolation {
namespace {

void decay(Scalar, const ScalarVector& y, ScalarVector& dy_dt) { dy_dt = -y; }

struct OneStep {
  Scalar error;
  Scalar estimate;
};

OneStep one_step_of_decay(Scalar h) {
  const Scalar tolerance = 1e-6;
  ExtrapolationIntegrator integrator(decay, tolerance);
  ScalarVector y_next;
  const Scalar estimate = integrator.step(0, h, ScalarVector::Ones(1), y_next);
  return {std::abs(y_next[0] - std::exp(-h)), estimate * tolerance * (1 + 1)};  // |y| <= 1
}

TEST(Extrapolation, HasOrderTwelve) {
  const OneStep coarse = one_step_of_decay(1.0), fine = one_step_of_decay(0.5);
  EXPECT_NEAR(static_cast<double>(std::log2(coarse.error / fine.error)), 13,
              0.5);  // per step: one order more
}

TEST(Extrapolation, ErrorEstimateIsAnUpperBoundNotFarOff) {
  for (const Scalar h : {Scalar(1.4), Scalar(0.8), Scalar(0.4)}) {
    const OneStep step = one_step_of_decay(h);
    EXPECT_GE(step.estimate, step.error);
    EXPECT_LE(step.estimate, 100 * step.error);
  }
}

TEST(Extrapolation, HarmonicOscillatorReturnsAfterTenPeriods) {
  ExtrapolationIntegrator integrator(
      [](Scalar, const ScalarVector& y, ScalarVector& dy_dt) { dy_dt << y[1], -y[0]; }, 1e-13);
  ScalarVector y(2);
  y << 1, 0;
  integrator.advance(0, 20 * std::numbers::pi_v<Scalar>, y);
  EXPECT_LT(std::abs(y[0] - 1), 1e-12);
  EXPECT_LT(std::abs(y[1]), 1e-12);
}

TEST(Extrapolation, FastDecayOntoASlowSolution) {
  // y = sin t + exp(-23000 t): the rate of the slender reference body about its axis.
  const double rate = 23000;
  ExtrapolationIntegrator integrator(
      [rate](Scalar t, const ScalarVector& y, ScalarVector& dy_dt) {
        dy_dt[0] = -rate * (y[0] - std::sin(t)) + std::cos(t);
      },
      1e-12);
  ScalarVector y = ScalarVector::Ones(1);
  integrator.advance(0, 1, y);
  EXPECT_LT(std::abs(y[0] - std::sin(Scalar(1))), 1e-12);
}

TEST(Extrapolation, ReportsASolutionThatEnds) {
  // y' = y^2, y(0) = 1 has its pole at t = 1.
  ExtrapolationIntegrator integrator(
      [](Scalar, const ScalarVector& y, ScalarVector& dy_dt) { dy_dt = y.cwiseAbs2(); }, 1e-12);
  ScalarVector y = ScalarVector::Ones(1);
  EXPECT_THROW(integrator.advance(0, 2, y), std::runtime_error);
}

}  // namespace
}  // namespace godobject::oracle::test_extrapolation
