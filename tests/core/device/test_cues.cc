// Cues for devices without force: impact speeds against closed forms, events once each.
#include "core/device/cues.h"

#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_cues {
namespace {

struct Ball {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = ImplicitEuler;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
  using Contacts = FixedContacts<1, 1, 1>;
};

/// A ball that flies at a plane z = 0; its sphere is at p_B.
Running<Ball> flying(const Vec3& p_B, const Twist& V_WB) {
  Running<Ball> run;
  run.par.num_bodies = 1;
  run.par.h = 1e-4;
  run.par.gravity_W = Vec3::Zero();
  run.constants().body = rigid_body(0.1, Vec3(1e-4, 1e-4, 1e-4).asDiagonal());
  run.par.contacts.num_spheres = run.par.contacts.num_surfaces = 1;
  run.par.contacts.spheres[0] = {.body = 0, .p_B = p_B, .radius = 0.01};
  run.par.contacts.surfaces[0].shape.kind = ShapeKind::plane;
  run.par.contacts.laws[0][0] = {.k = 2e4, .c = 1};
  EXPECT_EQ(validate(run.par), Invalid::nothing);
  place(run.x, 0, {.X_WB = {.p = Vec3(0, 0, 0.1)}, .V_WB = V_WB});
  return run;
}

/// Impact speeds of all contacts that begin within a time, s.
std::vector<Real> impacts(Running<Ball>& run, Real time) {
  ContactCue cue;
  std::vector<Real> speeds;
  cue.observe({}, run.out.bodies[0].V_WB);
  for (Real t = 0; t < time; t += run.par.h) {
    run.step();
    const Real speed = cue.observe(run.out.bodies[0].contact.F_W, run.out.bodies[0].V_WB);
    if (speed >= 0) speeds.push_back(speed);
  }
  return speeds;
}

TEST(Cues, ImpactSpeedIsThatOfTheContactPoint) {
  Random random(3);
  for (int round = 0; round < 50; ++round) {
    const Real v = random.log_uniform(0.02, 2), w = random.uniform(-1, 1);
    // with an offset sphere below the centre the spin adds nothing; beside it, it does
    const Vec3 p_B(random.uniform(-0.02, 0.02), 0, -0.02);
    Running<Ball> run = flying(p_B, {.w = Vec3(0, w, 0), .v = Vec3(random.uniform(-1, 1), 0, -v)});
    Real exact = 0;
    ContactCue cue;
    for (int n = 0; n < 100000 && exact == 0; ++n) {
      const RigidBodyState before = run.body();
      run.step();
      const Real speed = cue.observe(run.out.bodies[0].contact.F_W, run.out.bodies[0].V_WB);
      if (speed < 0) continue;
      const Vec3 r_W = before.X_WB.q * p_B - Vec3(0, 0, 0.01);
      exact = -(before.v_W + (before.X_WB.q * before.w_B).cross(r_W)).z();
      EXPECT_NEAR(speed, exact, 2e-3 * exact) << round;
    }
    EXPECT_GT(exact, 0) << round;
  }
}

TEST(Cues, AnImpactIsReportedOnceAndRestNever) {
  Running<Ball> run = flying(Vec3::Zero(), {.w = Vec3::Zero(), .v = Vec3(0, 0, -0.5)});
  run.par.gravity_W = Vec3(0, 0, -9.81);
  const std::vector<Real> speeds = impacts(run, 3);
  ASSERT_GT(speeds.size(), 1u);  // it bounces
  EXPECT_NEAR(speeds.front(), std::sqrt(0.25 + 2 * 9.81 * 0.09), 0.01);
  for (std::size_t i = 1; i < speeds.size(); ++i) EXPECT_LT(speeds[i], speeds[i - 1]) << i;
  const std::vector<Real> at_rest = impacts(run, 1);
  EXPECT_LE(at_rest.size(), 1u);  // the first step of the observer
}

TEST(Cues, DivergenceIsDistanceAndAngle) {
  Random random(4);
  for (int round = 0; round < 100; ++round) {
    const Pose X_WB{.p = random.vector(), .q = random.rotation()};
    const Real angle = random.uniform(0.01, 3.1);
    const Vec3 shift = random.vector();
    const Pose X_WD{.p = X_WB.p + shift, .q = exp_so3(Vec3(angle * random.direction())) * X_WB.q};
    EXPECT_NEAR(divergence(X_WD, X_WB).distance, shift.norm(), 1e-12);
    EXPECT_NEAR(divergence(X_WD, X_WB).angle, angle, 1e-6);
  }
}

/// The control to display ratio scales the shift of the target, after a gap too, and not its rotation.
TEST(Cues, DisplayRatioScalesTheShiftOfARelativeDevice) {
  const auto moved = [](Real ratio, int gap_at) {
    Running<OneBody<ImplicitEuler, RelativeDevice>> run;
    run.constants().body = rigid_body(0.1, Vec3(1e-4, 1e-4, 1e-4).asDiagonal());
    run.constants().coupling = {.k = 1000, .g = 20, .k_r = 1, .g_r = 0.03};
    run.constants().device.rise = 0;
    run.constants().device.display_ratio = ratio;
    EXPECT_EQ(validate(run.par), Invalid::nothing);
    place(run.x, 0, {});
    for (int n = 0; n < 400; ++n) {
      auto& in = run.device();
      in.valid = n != gap_at;
      in.dp_W = n < 100 ? Vec3(1e-4, 0, 0) * (n == gap_at + 1 && gap_at > 0 ? 2 : 1) : Vec3(0, 0, 0);
      in.dphi_W = n < 100 ? Vec3(0, 0, 1e-3) * (n == gap_at + 1 && gap_at > 0 ? 2 : 1) : Vec3(0, 0, 0);
      run.step();
    }
    return run.x.bodies[0].device.last.X_WD;
  };
  for (const int gap_at : {-1, 50}) {
    const Pose full = moved(1, gap_at), half = moved(0.5, gap_at);
    EXPECT_NEAR(full.p.x(), 0.0099, 2e-4) << gap_at;  // the engaging step takes no increment
    EXPECT_NEAR(half.p.x(), 0.5 * full.p.x(), 1e-12) << gap_at;
    EXPECT_NEAR(half.q.angularDistance(full.q), 0, 1e-12) << gap_at;
  }
}

TEST(Cues, DisplayRatioIsChecked) {
  Running<OneBody<ImplicitEuler, RelativeDevice>> run;
  run.constants().body = rigid_body(0.1, Vec3(1e-4, 1e-4, 1e-4).asDiagonal());
  run.constants().device.display_ratio = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_NE(validate(run.par), Invalid::nothing);
}

}  // namespace
}  // namespace godobject::test_cues
