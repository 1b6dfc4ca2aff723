#include "tests/oracle/target.h"

#include <gtest/gtest.h>

#include "tests/oracle/compare.h"
#include "tests/oracle/scenes.h"

namespace godobject::oracle::test_target {
namespace {

/// Velocities by fourth-order central differences of the poses.
RigidState with_numeric_velocities(const Target& target, double t) {
  const double h = 1e-3;
  const RigidState b2 = target.at(t - 2 * h), b1 = target.at(t - h), a1 = target.at(t + h),
                   a2 = target.at(t + 2 * h);
  RigidState D = target.at(t);
  D.v = (8 * (a1.p - b1.p) - (a2.p - b2.p)) / (12 * h);
  const Eigen::Vector4d qd =
      (8 * (a1.q.coeffs() - b1.q.coeffs()) - (a2.q.coeffs() - b2.q.coeffs())) / (12 * h);
  D.w = 2 * (Quaterniond(qd) * D.q.conjugate()).vec();
  return D;
}

TabulatedTarget tabulated_s1(double duration, double step) {
  const std::vector<double> times = uniform_times(duration, step);
  std::vector<Vector3d> p;
  std::vector<Quaterniond> q;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const RigidState D = scene_s1_target(times[i]);
    p.push_back(D.p);
    q.push_back(D.q);
    if (i % 3 == 1) q.back().coeffs() *= -1;  // the same attitude
  }
  return TabulatedTarget(times, p, q);
}

TEST(SceneS1Target, VelocitiesAreTheDerivativesOfThePose) {
  const FunctionTarget target(scene_s1_target);
  for (const double t : uniform_times(5, 0.037)) {
    const WorstDifference worst = worst_difference(target.at(t), with_numeric_velocities(target, t));
    EXPECT_LT(worst.v, 1e-9) << "t = " << t;
    EXPECT_LT(worst.w, 1e-8) << "t = " << t;
  }
}

TEST(TabulatedTarget, MeetsASmoothMotionBetweenItsSamples) {
  const TabulatedTarget target = tabulated_s1(2, 1e-3);
  WorstDifference worst;
  for (const double t : uniform_times(2, 0.000173)) {
    worst = larger(worst, worst_difference(target.at(t), scene_s1_target(t)));
  }
  EXPECT_LT(worst.p, 1e-14);
  EXPECT_LT(worst.q, 1e-14);
  EXPECT_LT(worst.v, 1e-11);
  EXPECT_LT(worst.w, 1e-11);
}

TEST(TabulatedTarget, ConvergesWithTheSpacingOfItsSamples) {
  const double t = 1.0 + 0.3e-3;
  const double coarse = (tabulated_s1(2, 40e-3).at(t).w - scene_s1_target(t).w).norm();
  const double fine = (tabulated_s1(2, 20e-3).at(t).w - scene_s1_target(t).w).norm();
  EXPECT_GT(coarse / fine, 16.0);  // fourth order or better
}

TEST(TabulatedTarget, VelocitiesAreTheDerivativesOfItsPose) {
  // 16 ms samples of a wild table: consistent whatever the quality of the fit.
  std::vector<double> times;
  std::vector<Vector3d> p;
  std::vector<Quaterniond> q;
  for (int i = 0; i < 5; ++i) {
    times.push_back(0.016 * i);
    p.emplace_back(0.01 * i * i, i % 2, -i);
    q.push_back(Quaterniond(2, i % 2, 0.3 * i, i % 3).normalized());
  }
  const TabulatedTarget target(times, p, q);
  for (const double t : {0.020, 0.025, 0.040}) {
    const double h = 1e-6;
    const RigidState before = target.at(t - h), now = target.at(t), after = target.at(t + h);
    const Eigen::Vector4d qd = (after.q.coeffs() - before.q.coeffs()) / (2 * h);
    EXPECT_LT(((after.p - before.p) / (2 * h) - now.v).norm(), 1e-5 * now.v.norm());
    EXPECT_LT((2 * (Quaterniond(qd) * now.q.conjugate()).vec() - now.w).norm(), 1e-5 * now.w.norm());
  }
}

TEST(TabulatedTarget, RefusesWhatItDoesNotKnow) {
  const std::vector<Vector3d> p(2, Vector3d::Zero());
  const std::vector<Quaterniond> q(2, Quaterniond::Identity());
  EXPECT_THROW(TabulatedTarget({0, 0}, p, q), std::invalid_argument);
  EXPECT_THROW(TabulatedTarget({0, 1, 2}, p, q), std::invalid_argument);
  const TabulatedTarget target({0, 1}, p, q);
  EXPECT_NO_THROW(target.at(1));
  EXPECT_THROW(target.at(1.001), std::out_of_range);
  EXPECT_THROW(target.at(-0.001), std::out_of_range);
}

}  // namespace
}  // namespace godobject::oracle::test_target
