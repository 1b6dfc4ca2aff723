#include "core/device/device.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_device {
namespace {

constexpr Real h = 1e-3;

/// A light body on a stiff, well damped spring: it is where its target is within a few milliseconds.
template <class DevicePart>
Running<OneBody<ImplicitEuler, DevicePart>> stiff_follower() {
  Running<OneBody<ImplicitEuler, DevicePart>> run;
  run.par.h = h;
  run.constants().body = rigid_body(0.01, 1e-5 * Mat3::Identity());
  run.constants().coupling = {.k = 1e5, .g = 60, .k_r = 100, .g_r = 0.06};
  run.constants().device.rise = 0;
  return run;
}

TEST(DeviceRamp, EngagingWaitsForAValidSample) {
  Running<OneBody<TrBdf2>> run;
  run.constants().body = rigid_body(0.1, 1e-3 * Mat3::Identity());
  run.constants().coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.03};
  run.constants().device.rise = 0.1;
  place(run.x, 0, {.X_WB = {.p = Vec3(1, 2, 3), .q = Quat::Identity()}, .V_WB = {}});
  run.device().valid = false;
  run.step(200);
  EXPECT_EQ(run.body().X_WB.p, Vec3(1, 2, 3));
  run.device().target.X_WD.p = Vec3(1, 2, 3);
  run.device().valid = true;
  run.step(200);
  EXPECT_LE((run.body().X_WB.p - Vec3(1, 2, 3)).norm(), 1e-12);
}

TEST(DeviceRamp, AGapThatIsTooLongToBeBridgedEndsTheEngagement) {
  for (const int gap : {1, 3, 4, 50}) {
    Running<OneBody<TrBdf2>> run;
    run.constants().body = rigid_body(0.1, 1e-3 * Mat3::Identity());
    run.constants().coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.03};
    run.constants().device.rise = 0.1;
    run.step(200);
    run.device().valid = false;
    run.step(gap);
    const Vec3 before = run.body().X_WB.p;
    run.device().valid = true;
    run.device().target.X_WD.p = Vec3(0.1, 0, 0);
    run.step();
    const bool reengages = gap > bridged_steps;
    EXPECT_TRUE(has(run.out.limited, Limited::ramp)) << "of the feedback at least, " << gap;
    EXPECT_EQ(run.x.bodies[0].device.ramp.s, reengages ? 0 : 1) << gap;
    EXPECT_EQ((run.body().X_WB.p - before).norm() < 1e-9, reengages) << gap;
  }
}

TEST(DeviceRamp, RisesLinearlyFromZeroInTheFirstEngagedStep) {
  Running<OneBody<ImplicitEuler>> run;
  run.constants().device.rise = 0.01;
  run.device().engaged = false;
  run.step(3);
  EXPECT_EQ(run.x.bodies[0].device.ramp.s, 0);
  run.device().engaged = true;
  for (int n = 0; n < 15; ++n) {
    run.step();
    EXPECT_NEAR(run.x.bodies[0].device.ramp.s, std::min(1.0, n * h / 0.01), 1e-12);
    if (n < 10) {
      EXPECT_TRUE(has(run.out.limited, Limited::ramp)) << n;
    }
  }
  for (int n = 0; n < 5; ++n) {
    EXPECT_FALSE(has(run.out.limited, Limited::ramp)) << n;
    run.step();
  }
  run.device().engaged = false;
  run.step();
  EXPECT_EQ(run.x.bodies[0].device.ramp.s, 0);
  EXPECT_FALSE(has(run.out.limited, Limited::ramp));
}

TEST(DeviceRamp, KeepsTheDampingRatio) {
  const SpringParams full{.k = 400, .g = 30, .k_r = 9, .g_r = 2}, half = ramped(full, 0.5);
  EXPECT_DOUBLE_EQ(half.g / std::sqrt(half.k), full.g / std::sqrt(full.k));
  EXPECT_DOUBLE_EQ(half.g_r / std::sqrt(half.k_r), full.g_r / std::sqrt(full.k_r));
  EXPECT_EQ(ramped(full, 0).k + ramped(full, 0).g + ramped(full, 0).k_r + ramped(full, 0).g_r, 0);
}

TEST(PoseDeviceDrives, ABodyToItsPose) {
  auto run = stiff_follower<PoseDevice>();
  const Pose X_WD{.p = Vec3(0.1, -0.2, 0.3), .q = Quat(0.6, 0, 0.8, 0)};
  run.device().target.X_WD = X_WD;
  run.step(300);
  EXPECT_LE((run.out.bodies[0].X_WB.p - X_WD.p).norm(), 1e-9);
  EXPECT_LE(run.out.bodies[0].X_WB.q.angularDistance(X_WD.q), 1e-7);
}

TEST(PoseDeviceDrives, QuaternionsOfEitherSignAlike) {
  auto plus = stiff_follower<PoseDevice>(), minus = stiff_follower<PoseDevice>();
  for (int n = 0; n < 200; ++n) {
    const Real a = 0.02 * n;
    plus.device().target.X_WD.q = Quat(std::cos(a), std::sin(a), 0, 0);
    minus.device().target.X_WD.q = plus.device().target.X_WD.q;
    if (n % 3 == 0) minus.device().target.X_WD.q.coeffs() *= -1;
    plus.step();
    minus.step();
    ASSERT_LE((plus.body().w_B - minus.body().w_B).norm(), 1e-9);
    ASSERT_LE(plus.body().X_WB.q.angularDistance(minus.body().X_WB.q), 1e-9);
  }
}

/// After the bridge: three steps as it moved.
TEST(PoseDeviceDrives, LostSamplesHoldTheTargetAtRest) {
  auto run = stiff_follower<PoseDevice>();
  for (int n = 1; n <= 100; ++n) {
    run.device().target.X_WD.p = Vec3(1e-3 * n, 0, 0);
    run.device().target.V_WD.v = Vec3(1, 0, 0);
    run.step();
  }
  run.device().valid = false;
  run.device().target.X_WD.p = Vec3(99, 0, 0);
  for (int n = 0; n < 300; ++n) {
    run.step();
    ASSERT_TRUE(has(run.out.limited, Limited::held));
    ASSERT_FALSE(any(run.out.fault));
  }
  EXPECT_NEAR(run.body().X_WB.p.x(), 0.1 + 1e-3 * bridged_steps, 1e-9);
  EXPECT_LE(run.body().v_W.norm(), 1e-9);
}

TEST(RelativeDeviceDrives, FromWhereTheBodyIs) {
  auto run = stiff_follower<RelativeDevice>();
  const Vec3 start(5, 6, 7);
  place(run.x, 0, {.X_WB = {.p = start, .q = Quat(0.6, 0, 0, 0.8)}, .V_WB = {}});
  run.step(10);
  EXPECT_LE((run.body().X_WB.p - start).norm(), 1e-12);
  for (int n = 0; n < 100; ++n) {
    run.device().dp_W = Vec3(1e-4, 0, 0);
    run.device().dphi_W = Vec3(0, 0, 1e-3);
    run.step();
  }
  run.device() = {};
  run.step(300);
  EXPECT_LE((run.body().X_WB.p - start - Vec3(0.01, 0, 0)).norm(), 1e-9);
  const Quat expected = Quat(std::cos(0.05), 0, 0, std::sin(0.05)) * Quat(0.6, 0, 0, 0.8);
  EXPECT_LE(run.body().X_WB.q.angularDistance(expected), 1e-7);
}

TEST(RelativeDeviceDrives, NothingWhileTheClutchIsOpenOrTheSampleLost) {
  auto run = stiff_follower<RelativeDevice>();
  run.step(10);
  for (int n = 0; n < 200; ++n) {
    run.device().dp_W = Vec3(1e-3, 0, 0);
    run.device().clutch = n % 2 == 0;
    run.device().valid = n % 2 == 1;
    run.step();
    ASSERT_EQ(has(run.out.limited, Limited::held), n % 2 == 0);
  }
  EXPECT_LE(run.body().X_WB.p.norm(), 1e-12);
}

TEST(AdmittanceDeviceDrives, FreeBodyByNewtonsLaw) {
  Running<OneBody<TrBdf2, AdmittanceDevice, None>> run;
  run.par.h = h;
  run.constants().body = rigid_body(2, Vec3(1, 2, 4).asDiagonal());
  run.constants().device.rise = 0;
  run.device().F_WB = {.tau = Vec3(0, 0, 0.4), .f = Vec3(6, 0, 0)};
  run.step(1000);
  EXPECT_NEAR(run.body().v_W.x(), 3, 1e-9);
  EXPECT_NEAR(run.body().X_WB.p.x(), 1.5, 1e-2);
  EXPECT_NEAR(run.body().w_B.z(), 0.1, 1e-9);
}

TEST(AdmittanceDeviceDrives, AgainstItsSpringTiedToWhereItWasEngaged) {
  auto run = stiff_follower<AdmittanceDevice>();
  place(run.x, 0, {.X_WB = {.p = Vec3(1, 2, 3), .q = Quat::Identity()}, .V_WB = {}});
  run.device().F_WB = {.tau = Vec3(0, 0, 1), .f = Vec3(10, 0, 0)};
  run.step(1000);
  EXPECT_NEAR(run.body().X_WB.p.x() - 1, 10 / 1e5, 1e-9);
  EXPECT_NEAR(2 * std::asin(run.body().X_WB.q.z()), 1.0 / 100, 1e-8);
  run.device().valid = false;  // the hand is lost: no force
  run.step(1000);
  EXPECT_NEAR(run.body().X_WB.p.x(), 1, 1e-9);
  EXPECT_TRUE(has(run.out.limited, Limited::held));
}

/// Faster than half a turn in a step: the bridged attitude is a valid one all the same.
TEST(DeviceGap, IsBridgedWithAnAttitudeHoweverFastItTurned) {
  for (const Real turn_rate : {1e3, 1e4, 1e6, 1e12}) {
    Running<OneBody<TrBdf2>> run;
    run.constants().body = rigid_body(0.1, 1e-3 * Mat3::Identity());
    run.constants().coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.03};
    run.device().target.V_WD.w = Vec3(0, turn_rate, 0);
    run.step(3);
    run.device().valid = false;
    run.step(3);
    EXPECT_EQ(run.out.fault, Fault::none);
    EXPECT_NEAR(run.x.bodies[0].device.last.X_WD.q.norm(), 1, 1e-12) << turn_rate;
    pass_time(run.x.bodies[0].device, 2 * h, h);
    EXPECT_NEAR(run.x.bodies[0].device.last.X_WD.q.norm(), 1, 1e-12) << turn_rate;
  }
}

}  // namespace
}  // namespace godobject::test_device
