#include "hal/joint/velocity_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace godobject::test_velocity_estimator {
namespace {

constexpr double quantum = 1e-4;
constexpr Nanoseconds period_ns = 1'000'000;

double quantised(double x) { return quantum * std::round(x / quantum); }

struct Errors {
  double estimator_rms = 0;
  double difference_rms = 0;
};

// Returns the errors of the estimator and of plain differences on a quantised x(t), after the window has
// filled.
Errors errors_on(const std::function<double(double)>& x, const std::function<double(double)>& x_dot,
                 int samples) {
  VelocityEstimator estimator(quantum);
  double last = quantised(x(0)), sum_estimator = 0, sum_difference = 0;
  int count = 0;
  for (int k = 0; k < samples; ++k) {
    const double t = 1e-9 * static_cast<double>(k * period_ns);
    const double now = quantised(x(t));
    const double estimate = estimator.update(now, k * period_ns);
    const double difference = (now - last) / (1e-9 * static_cast<double>(period_ns));
    last = now;
    if (k < 2 * static_cast<int>(VelocityEstimator::capacity)) continue;
    sum_estimator += std::pow(estimate - x_dot(t), 2);
    sum_difference += std::pow(difference - x_dot(t), 2);
    ++count;
  }
  return {std::sqrt(sum_estimator / count), std::sqrt(sum_difference / count)};
}

TEST(VelocityEstimator, ZeroAtStandstill) {
  VelocityEstimator estimator(quantum);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(estimator.update(0.37, k * period_ns), 0);
}

TEST(VelocityEstimator, ConvergesToZeroAfterMotion) {
  VelocityEstimator estimator(quantum);
  double v = 0;
  for (int k = 0; k < 20; ++k) v = estimator.update(quantised(0.5e-3 * k), k * period_ns);
  EXPECT_NEAR(v, 0.5, 0.01);
  for (int k = 20; k < 40; ++k) v = estimator.update(quantised(0.5e-3 * 19), k * period_ns);
  EXPECT_EQ(v, 0);
}

TEST(VelocityEstimator, SlowMotionBelowOneCountPerSample) {
  for (const double counts_per_sample : {0.07, 0.23, 0.61, 0.9}) {
    const double v = counts_per_sample * quantum / 1e-3;
    const Errors errors = errors_on([v](double t) { return v * t; }, [v](double) { return v; }, 2000);
    EXPECT_LT(errors.estimator_rms, errors.difference_rms / 5) << counts_per_sample;
    EXPECT_LT(errors.estimator_rms, 0.07 * quantum / 1e-3) << counts_per_sample;
  }
}

TEST(VelocityEstimator, QuantisedSine) {
  constexpr double amplitude = 0.05, omega = 2 * std::numbers::pi * 0.5;
  const Errors errors = errors_on([](double t) { return amplitude * std::sin(omega * t); },
                                  [](double t) { return amplitude * omega * std::cos(omega * t); }, 4000);
  EXPECT_LT(errors.estimator_rms, errors.difference_rms / 5);
}

TEST(VelocityEstimator, FollowsAStepOfVelocityPromptly) {
  VelocityEstimator estimator(quantum);
  double x = 0;
  int k = 0;
  for (; k < 50; ++k) estimator.update(quantised(x), k * period_ns);
  double v = 0;
  constexpr double v_new = 1;  // ten counts per sample
  for (int i = 0; i < 3; ++i, ++k) v = estimator.update(quantised(x += v_new * 1e-3), k * period_ns);
  EXPECT_NEAR(v, v_new, 0.1 * v_new);
}

TEST(VelocityEstimator, IrregularSampleTimes) {
  VelocityEstimator estimator(quantum);
  Nanoseconds t_ns = 0;
  constexpr double v = 0.3;
  for (int k = 0; k < 200; ++k) {
    t_ns += period_ns + (k * 7919 % 13 - 6) * Nanoseconds{60'000} + (k % 17 == 0 ? 4 * period_ns : 0);
    const double estimate = estimator.update(quantised(v * 1e-9 * static_cast<double>(t_ns)), t_ns);
    if (k <= 20) continue;
    EXPECT_NEAR(estimate, v, 0.1 * quantum / 1e-3);
  }
}

TEST(VelocityEstimator, RestartsAfterReset) {
  VelocityEstimator estimator(quantum);
  for (int k = 0; k < 20; ++k) estimator.update(1e-3 * k, k * period_ns);
  estimator.reset();
  EXPECT_EQ(estimator.update(5, 20 * period_ns), 0);
  EXPECT_NEAR(estimator.update(5.001, 21 * period_ns), 1, 1e-9);
}

}  // namespace
}  // namespace godobject::test_velocity_estimator
