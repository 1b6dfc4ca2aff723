#include "core/device/feedback.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_feedback {
namespace {

TEST(Feedback, IsEquationEight) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const SpringParams gains{.k = random.uniform(0, 1e3),
                             .g = random.uniform(0, 10),
                             .k_r = random.uniform(0, 5),
                             .g_r = random.uniform(0, 1)};
    const RigidBodyState x{.X_WB = {.p = random.vector(), .q = random.rotation()},
                           .v_W = random.vector(),
                           .w_B = random.vector()};
    const Target d{.X_WD = {.p = random.vector(), .q = random.rotation()},
                   .V_WD = {.w = random.vector(), .v = random.vector()}};
    const Vec3 phi_B = rotation_error(x.X_WB.q, d.X_WD.q, Vec3::Zero()).phi_B;
    // alpha u in world axes, from q_D q^-1.
    const Eigen::AngleAxis<Real> e_r(d.X_WD.q * x.X_WB.q.conjugate());
    const Vec3 w_W = x.X_WB.q * x.w_B;
    const Wrench F = LimitedFeedback::wrench(gains, x, d, phi_B);
    EXPECT_LE((F.f - (gains.g * (x.v_W - d.V_WD.v) + gains.k * (x.X_WB.p - d.X_WD.p))).norm(), 1e-10);
    const Real alpha = e_r.angle() > pi ? e_r.angle() - 2 * pi : e_r.angle();
    if (std::abs(alpha) > 3) continue;  // beyond, the side of the half turn is a matter of history
    EXPECT_LE((F.tau - (gains.g_r * (w_W - d.V_WD.w) - gains.k_r * alpha * e_r.axis())).norm(), 1e-10);
  }
}

/// Wrench shown after `steps` steps towards `wanted`.
Wrench shown(const FeedbackParams& par, const Wrench& wanted, int steps, Limited& limited) {
  LimitedFeedback::State x;
  LimitedFeedback::Output out;
  for (int n = 0; n < steps; ++n) {
    limited = Limited::none;
    LimitedFeedback::show(par, wanted, 1e-3, x, out, limited);
  }
  return out.F_D;
}

TEST(Feedback, WithinItsLimitsIsShownAsItIs) {
  Limited limited;
  const Wrench F = shown({}, {.tau = Vec3(0.01, 0, 0), .f = Vec3(0, 0.3, 0)}, 1, limited);
  EXPECT_EQ(F.f, Vec3(0, 0.3, 0));
  EXPECT_EQ(F.tau, Vec3(0.01, 0, 0));
  EXPECT_EQ(limited, Limited::none);
}

TEST(Feedback, KeepsItsDirectionAtTheLimits) {
  const FeedbackParams par{
      .gains = {}, .max_force = 5, .max_torque = 0.2, .max_force_rate = 1e9, .max_torque_rate = 1e9};
  Limited limited;
  const Wrench F = shown(par, {.tau = Vec3(3, 0, 4), .f = Vec3(0, 300, -400)}, 1, limited);
  EXPECT_LE((F.f - Vec3(0, 3, -4)).norm(), 1e-12);
  EXPECT_LE((F.tau - Vec3(0.12, 0, 0.16)).norm(), 1e-12);
  EXPECT_EQ(limited, Limited::force | Limited::torque);
}

TEST(Feedback, ApproachesAtItsRate) {
  const FeedbackParams par{
      .gains = {}, .max_force = 5, .max_torque = 0.5, .max_force_rate = 100, .max_torque_rate = 10};
  Limited limited;
  const Wrench F = shown(par, {.tau = Vec3(0.4, 0, 0), .f = Vec3(0, 4, 0)}, 10, limited);
  EXPECT_LE((F.f - Vec3(0, 1, 0)).norm(), 1e-12);
  EXPECT_LE((F.tau - Vec3(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(limited, Limited::force_rate | Limited::torque_rate);
  const Wrench later = shown(par, {.tau = Vec3(0.4, 0, 0), .f = Vec3(0, 4, 0)}, 60, limited);
  EXPECT_LE((later.f - Vec3(0, 4, 0)).norm(), 1e-12);
  EXPECT_EQ(limited, Limited::none);
}

TEST(Feedback, GainsOfZeroShowNothing) {
  Running<OneBody<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback>> run;
  run.constants().coupling = {.k = 1000, .g = 60, .k_r = 1, .g_r = 1};
  run.device().target.X_WD.p = Vec3(1, 0, 0);
  run.step(1000);
  EXPECT_EQ(run.out.bodies[0].feedback.F_D.f, Vec3(Vec3::Zero()));
  EXPECT_EQ(run.out.limited, Limited::none);
}

/// The displayed wrench stays for three steps, or for the time that the device sets.
TEST(Feedback, FadesOutWhenTheSampleIsLost) {
  for (const int still : {3, 30}) {
    Running<OneBody<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback>> run;
    run.par.gravity_W = Vec3(0, 0, -9.81);
    run.constants().coupling = {.k = 100, .g = 20, .k_r = 1, .g_r = 1};
    run.constants().feedback.gains.k = 50;
    run.constants().device.rise = 0;
    run.constants().device.stale = 1e-3 * still;
    run.step(3000);
    const Real f = run.out.bodies[0].feedback.F_D.f.z();
    EXPECT_NEAR(f, -9.81 * 50 / 100, 1e-6);  // m g on the coupling, seen through the gain of the feedback
    run.device().valid = false;
    run.step(still);
    EXPECT_EQ(run.out.bodies[0].feedback.F_D.f.z(), f);
    run.step();
    EXPECT_NEAR(run.out.bodies[0].feedback.F_D.f.z(), f + 0.5, 1e-12);
    run.step(20);
    EXPECT_EQ(run.out.bodies[0].feedback.F_D.f.z(), 0);
  }
}

}  // namespace
}  // namespace godobject::test_feedback
