// Metrics of generated motions and forces whose values are known in closed form.
#include "platform/trace/metrics.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace godobject::test::test_metrics {
namespace {

using std::numbers::pi;

constexpr double idle = 0.005;  // m/s

MotionSamples sampled(
    double time, double dt, const std::function<Vec3(double)>& p,
    const std::function<Quat(double)>& q = [](double) { return Quat::Identity(); }) {
  MotionSamples samples;
  const auto n = static_cast<int>(std::lround(time / dt));
  for (int i = 0; i <= n; ++i) {
    const double t = time * i / n;
    samples.t.push_back(7 + t);
    samples.p.push_back(p(t));
    samples.q.push_back(q(t));
  }
  return samples;
}

/// Position along a minimum-jerk reach of length 1 in the time 1; at rest outside of it.
double reach(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

const Vec3 direction = Vec3(1, -2, 2) / 3;

// integral of |jerk|^2 = 720 L^2 / T^5 and v_peak = 15 L / (8 T), so T^3 / v_peak^2 integral = 204.8
const double of_reach = -std::log(204.8);

TEST(Metrics, ALineHasItsLengthAndOneSpeed) {
  const MotionSamples line =
      sampled(2, 1e-3, [](double t) -> Vec3 { return Vec3(1, 2, 3) + 0.15 * t * direction; });
  const MotionMetrics m = motion_metrics(line, idle).value();
  EXPECT_NEAR(m.time, 2, 1e-12);
  EXPECT_NEAR(m.path, 0.3, 1e-9);
  EXPECT_NEAR(m.mean_speed, 0.15, 1e-9);
  EXPECT_NEAR(m.peak_speed, 0.15, 1e-9);
  EXPECT_NEAR(m.angle, 0, 1e-9);
  EXPECT_EQ(m.idle_share, 0);
}

TEST(Metrics, ACircleHasItsCircumferenceAndJerk) {
  constexpr double r = 0.05, w = 2 * pi / 1.5, time = 3;  // twice round
  for (const double dt : {1e-3, 5e-3, 1.0 / 60}) {
    const MotionSamples circle =
        sampled(time, dt, [](double t) { return Vec3(r * std::cos(w * t), 0.2, r * std::sin(w * t)); });
    const MotionMetrics m = motion_metrics(circle, idle).value();
    EXPECT_NEAR(m.path, 2 * 2 * pi * r, 1e-4 * r) << dt;
    EXPECT_NEAR(m.peak_speed, r * w, 1e-4 * r * w) << dt;
    // |jerk| = r w^3 and |v| = r w: T^3 / v^2 integral = (w T)^4
    EXPECT_NEAR(m.log_dimensionless_jerk.value(), -4 * std::log(w * time), 0.01) << dt;
  }
}

TEST(Metrics, AMinimumJerkReachHasTheLogDimensionlessJerkOfItsClosedForm) {
  for (const double time : {0.5, 1.0, 4.0})
    for (const double length : {0.02, 0.3}) {
      const MotionSamples samples =
          sampled(time, 1e-3, [&](double t) -> Vec3 { return length * reach(t / time) * direction; });
      const MotionMetrics m = motion_metrics(samples, idle).value();
      EXPECT_NEAR(m.log_dimensionless_jerk.value(), of_reach, 1e-4) << time << ' ' << length;
      EXPECT_NEAR(m.path, length, 1e-6 * length);
      EXPECT_NEAR(m.mean_speed, length / time, 1e-6 * length / time);
      EXPECT_NEAR(m.peak_speed, 15 * length / (8 * time), 1e-5 * length / time);
    }
}

TEST(Metrics, TwoReachesAreLessSmoothThanOne) {
  const auto twice = [](double t) -> Vec3 { return 0.05 * (reach(t) + reach(t - 1)) * direction; };
  const MotionMetrics m = motion_metrics(sampled(2, 1e-3, twice), idle).value();
  // Two reaches: T^3 is 8 times, the integral twice as large, the peak the same
  EXPECT_NEAR(m.log_dimensionless_jerk.value(), of_reach - std::log(16), 0.1);
}

/// Rounds to the counts of an encoder.
Vec3 counted(const Vec3& p) {
  constexpr double count = 50e-6;  // m
  return count * (p / count).array().round().matrix();
}

TEST(Metrics, CountsOfAnEncoderDoNotLengthenThePath) {
  const auto p = [](double t) -> Vec3 {
    return 0.1 * reach(t) * direction + 30e-6 * std::sin(2 * pi * 157 * t) * Vec3(1, 1, 1);
  };
  const MotionSamples samples = sampled(1, 1e-3, [&](double t) { return counted(p(t)); });
  double unfiltered = 0;
  for (std::size_t i = 1; i < samples.p.size(); ++i) unfiltered += (samples.p[i] - samples.p[i - 1]).norm();
  EXPECT_GT(unfiltered, 0.11);
  const MotionMetrics m = motion_metrics(samples, idle).value();
  EXPECT_NEAR(m.path, 0.1, 1e-4);
  EXPECT_NEAR(m.log_dimensionless_jerk.value(), of_reach, 0.05);
}

TEST(Metrics, HalfOfThePowerPassesAtTheCutOff) {
  constexpr double dt = 1e-3, cut_off = 5.6;  // s, Hz
  const auto gain = [&](double frequency) {
    Eigen::MatrixXd x(2001, 1);
    for (int i = 0; i < x.rows(); ++i) x(i, 0) = std::cos(2 * pi * frequency * dt * (i - 1000));
    return Smoothing(dt).derivative(x, 0)(1000, 0);
  };
  EXPECT_NEAR(gain(cut_off), std::sqrt(0.5), 0.02);
  EXPECT_NEAR(gain(cut_off / 3), 1, 0.01);
  EXPECT_NEAR(gain(cut_off * 4), 0, 0.1);
}

TEST(Metrics, RestIsIdleAndHasNoSmoothness) {
  const MotionSamples still =
      sampled(2, 1e-3, [](double t) { return counted(Vec3(40e-6 * std::sin(313 * t), 0, 0)); });
  const MotionMetrics m = motion_metrics(still, idle).value();
  EXPECT_EQ(m.idle_share, 1);
  EXPECT_FALSE(m.log_dimensionless_jerk.has_value());
}

TEST(Metrics, TheIdleShareIsTheTimeBelowTheSpeed) {
  // 1 s at rest, 3 s at 0.1 m/s
  const MotionSamples samples =
      sampled(4, 1e-3, [](double t) -> Vec3 { return 0.1 * std::max(t - 1, 0.0) * direction; });
  EXPECT_NEAR(motion_metrics(samples, idle).value().idle_share, 0.25, 0.02);
  EXPECT_EQ(motion_metrics(samples, 0.2).value().idle_share, 1);
}

TEST(Metrics, TurnsAreCountedAndSignsOfQuaternionsAreNot) {
  constexpr double w = 2 * pi / 1.25;  // rad/s, four turns in 5 s
  const auto turned = [](double t) {
    Quat q(Eigen::AngleAxisd(w * t, direction));
    if (static_cast<int>(1000 * t) % 2 == 1) q.coeffs() *= -1;
    return q;
  };
  const MotionMetrics m = motion_metrics(sampled(
                                             5, 1e-3, [](double) { return Vec3::Zero(); }, turned),
                                         idle)
                              .value();
  EXPECT_NEAR(m.angle, 4 * 2 * pi, 1e-4);
  EXPECT_NEAR(m.path, 0, 1e-12);
}

TEST(Metrics, RowsBesidesTheRegularOnesChangeLittle) {
  const auto p = [](double t) -> Vec3 { return 0.1 * reach(t / 2) * direction; };
  MotionSamples samples = sampled(2, 5e-3, p);
  const double t = 7.5021;  // the row of a fault
  const auto place = std::ranges::lower_bound(samples.t, t) - samples.t.begin();
  samples.t.insert(samples.t.begin() + place, t);
  samples.p.insert(samples.p.begin() + place, p(t - 7));
  samples.q.insert(samples.q.begin() + place, Quat::Identity());
  const MotionMetrics m = motion_metrics(samples, idle).value();
  EXPECT_NEAR(m.path, 0.1, 1e-6);
  EXPECT_NEAR(m.log_dimensionless_jerk.value(), of_reach, 1e-3);
}

TEST(Metrics, TooFewOrTooIrregularSamplesHaveNone) {
  const auto p = [](double t) -> Vec3 { return t * direction; };
  EXPECT_TRUE(motion_metrics(sampled(0.31, 1e-3, p), idle).has_value());
  EXPECT_FALSE(motion_metrics(sampled(0.29, 1e-3, p), idle).has_value());
  EXPECT_TRUE(motion_metrics(sampled(2, 0.02, p), idle).has_value());
  EXPECT_FALSE(motion_metrics(sampled(2, 0.025, p), idle).has_value());
  EXPECT_FALSE(motion_metrics({}, idle).has_value());
  MotionSamples gap = sampled(1, 1e-3, p);
  gap.t.back() = 1e9;
  EXPECT_FALSE(motion_metrics(gap, idle).has_value());
}

TEST(Metrics, ForcesHavePeakMeanAndTimeAboveAThreshold) {
  // A triangle: 0 N, 8 N at 1 s, 0 N at 2 s; then 2 s without force
  const std::vector<double> t{0, 1, 2, 4}, F{0, 8, 0, 0};
  const ForceMetrics m = force_metrics(t, F, 2);
  EXPECT_EQ(m.peak, 8);
  EXPECT_DOUBLE_EQ(m.mean, 8.0 / 4);
  EXPECT_DOUBLE_EQ(m.above, 2 * 0.75);
  EXPECT_EQ(force_metrics(t, F, 8).above, 0);
}

TEST(Metrics, EpisodesAreCountedAcrossShortInterruptions) {
  const std::vector<double> t{0, 1, 2, 3, 4, 5, 6, 7};
  const auto count = [&](const std::vector<bool>& holds, double min_gap) {
    return episodes(t, holds, min_gap);
  };
  const std::vector<bool> two{false, true, true, false, true, false, false, false};
  EXPECT_EQ(count(two, 0).begun, 2u);
  EXPECT_EQ(count(two, 0).ended, 2u);
  EXPECT_DOUBLE_EQ(count(two, 0).time, 3);
  EXPECT_EQ(count(two, 1).begun, 2u);
  EXPECT_EQ(count(two, 1.5).begun, 1u);
  EXPECT_EQ(count(two, 1.5).ended, 1u);
  const std::vector<bool> from_start_to_end{true, false, true, true, true, true, false, true};
  EXPECT_EQ(count(from_start_to_end, 0).begun, 3u);
  EXPECT_EQ(count(from_start_to_end, 0).ended, 2u);
  const std::vector<bool> never(8, false);
  EXPECT_EQ(count(never, 1).begun + count(never, 1).ended, 0u);
}

}  // namespace
}  // namespace godobject::test::test_metrics
