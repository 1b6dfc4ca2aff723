#include "hal/base/one_euro.h"

#include <gtest/gtest.h>

#include <random>

namespace godobject::test_one_euro {
namespace {

Pose pose(double x, double angle) {
  return {.p = Vec3(x, 0, 0), .q = Quat(std::cos(angle / 2), 0, std::sin(angle / 2), 0)};
}

TEST(OneEuro, OffIsTheSampleItself) {
  OneEuro filter({});
  EXPECT_EQ(filter.filter(pose(1, 1), 0.01).p.x(), 1);
  EXPECT_EQ(filter.filter(pose(2, 1), 0.01).p.x(), 2);
}

TEST(OneEuro, AHandAtRestTremblesLess) {
  OneEuro filter({.min_cutoff_hz = 1, .cutoff_slope_s_per_m = 20});
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1e-4);
  double raw = 0, filtered = 0, turn = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pose in = pose(noise(random), noise(random));
    const Pose out = filter.filter(in, 1.0 / 60);
    if (i < 300) continue;
    raw += in.p.squaredNorm();
    filtered += out.p.squaredNorm();
    turn += out.q.vec().squaredNorm();
  }
  EXPECT_LT(filtered, 0.15 * raw);
  EXPECT_LT(turn, 0.05 * raw) << "half angles";
}

TEST(OneEuro, AFastHandIsNotHeldBack) {
  const auto lag = [](double slope) {
    OneEuro filter({.min_cutoff_hz = 1, .cutoff_slope_s_per_m = slope});
    double last = 0;
    for (int i = 0; i < 120; ++i) last = filter.filter(pose(0.5 * i / 60, 0), 1.0 / 60).p.x() - 0.5 * i / 60;
    return -last / 0.5;
  };
  EXPECT_GT(lag(0), 0.12) << "s: a low-pass of 1 Hz";
  EXPECT_LT(lag(50), 0.02);
}

TEST(OneEuro, AttitudeTakesTheShortWay) {
  OneEuro filter({.min_cutoff_hz = 5, .cutoff_slope_s_per_m = 0});
  static_cast<void>(filter.filter(pose(0, 0.1), 0.01));
  const Quat q = pose(0, 0.2).q;
  const Pose out = filter.filter({.p = Vec3::Zero(), .q = Quat(-q.w(), -q.x(), -q.y(), -q.z())}, 0.01);
  EXPECT_LT(out.q.angularDistance(q), 0.1);
  EXPECT_NEAR(out.q.norm(), 1, 1e-12);
}

}  // namespace
}  // namespace godobject::test_one_euro
