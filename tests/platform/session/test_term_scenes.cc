// Shipped scenes of gears, springs and loops, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/scene/joint/joints.h"
#include "platform/simulated/session.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_term_scenes {
namespace {

/// Run of a scene without buses.
struct SceneRun {
  SceneConfig scene;
  Session::Made made;
  CycleRecord record;

  explicit SceneRun(const SceneConfig& of)
      : scene(of), made(make_session(of, Motion(of), BusChoice::direct)), record(made.session->at_start()) {}
  void run_to(double t) {
    while (record.t < t - scene.step / 2) {
      made.session->cycle(record);
      ASSERT_EQ(record.fault, Fault::none) << "at " << record.t << " s";
    }
  }
  std::size_t index(const std::string& body) const { return *body_named(scene, body); }
  const BodyView& body(const std::string& name) const { return record.bodies[index(name)]; }
  double coordinate(const std::string& name) const {
    const CoordinateOfJoint q = coordinate_named(scene, name);
    return coordinates_at_start(placed(scene, record), *q.joint)[static_cast<Eigen::Index>(q.number)];
  }
  double gear_torque(std::size_t gear) const {
    return record.term_forces[scene.springs.size() + gear].tau.norm();
  }
};

TEST(TermScenes, OneHandleClosesBothBladesAndFeelsTheWire) {
  for (const char* const integrator : integrator_names) {
    SceneConfig scene = load_shipped("scissors.toml");
    scene.integrator = integrator;
    SceneRun run(scene);
    run.run_to(0.7);  // in the air
    EXPECT_LT(std::abs(run.gear_torque(0)), 1e-4) << integrator;
    run.run_to(1.25);  // closed on the wire
    EXPECT_NEAR(run.coordinate("left"), 0.5 * run.coordinate("handle"), 1e-7) << integrator;
    EXPECT_NEAR(run.coordinate("right"), -0.5 * run.coordinate("handle"), 1e-7) << integrator;
    const BodyView& handle = run.body("handle");
    // the hand's torque about the hinge, 0.03 m before the centre of mass, closes against both gears
    const Vec3 hinge(-0.12, 0, 0);
    const double of_hand = handle.coupling_B.tau.z() + (handle.X_WB.p - hinge).cross(handle.coupling_B.f).z();
    const double of_gears = 0.5 * (run.gear_torque(0) + run.gear_torque(1));
    EXPECT_GT(of_gears, 5e-3) << integrator;
    EXPECT_NEAR(std::abs(of_hand), of_gears, 0.02 * of_gears) << integrator;
    EXPECT_NEAR(run.gear_torque(0), run.gear_torque(1), 0.02 * run.gear_torque(0)) << integrator;
    EXPECT_GT(std::abs(handle.feedback_D.tau.z()), 1e-3) << integrator << ": felt";
  }
}

TEST(TermScenes, NeedleDriverGripsItsNeedle) {
  for (const char* const integrator : integrator_names) {
    SceneConfig scene = load_shipped("needle-driver.toml");
    scene.integrator = integrator;
    SceneRun run(scene);
    const auto needle_in_clevis = [&] {
      const Pose &X_WN = run.body("needle").X_WB, &X_WC = run.body("clevis").X_WB;
      return Vec3(X_WC.q.conjugate() * (X_WN.p - X_WC.p));
    };
    run.run_to(1);
    const Vec3 before = needle_in_clevis();
    EXPECT_GT(run.gear_torque(0), 1e-3) << integrator;
    EXPECT_GT(run.body("grip").feedback_D.tau.norm(), 1e-3) << integrator << ": felt at the jaw";
    double slipped = 0;
    for (double t = 1; t < 3; t += 0.01) {
      run.run_to(t);
      slipped = std::max(slipped, (needle_in_clevis() - before).norm());
    }
    EXPECT_LT(slipped, 5e-4) << integrator;
    EXPECT_NEAR(run.coordinate("left"), -run.coordinate("right"), 1e-7) << integrator;
  }
}

/// A chain of hinges bends by F (L - x_i) / k at each: F / k sum (L - x_i)^2 at the tip.
TEST(TermScenes, CatheterBendsAsItsHingesSay) {
  SceneConfig scene = load_shipped("catheter.toml");
  const double F = 4e-4, k = 0.02, link = 0.01;
  scene.forces.front().F_W = Vec3(0, 0, -F);  // small angles
  SceneRun run(scene);
  run.run_to(5);
  const Pose &X_WB = run.body("segment_1").X_WB, &X_WT = run.body("segment_12").X_WB;
  const Vec3 tip = X_WB.q.conjugate() * (X_WT.p + X_WT.q * Vec3(link / 2, 0, 0) - X_WB.p);
  double deflection = 0;
  for (int j = 1; j <= 11; ++j) deflection += F / k * link * link * j * j;
  EXPECT_NEAR(-tip.z(), deflection, 2e-3 * deflection);
  EXPECT_NEAR(tip.y(), 0, 1e-9);
}

TEST(TermScenes, FourBarKeepsItsEnergyAndItsLoop) {
  SceneRun run(load_shipped("four-bar.toml"));
  const double start = run.record.energy.total;
  double most = 0, turned = 0;
  while (run.record.t < 5 - 1e-6) {
    run.run_to(run.record.t + 0.01);
    most = std::max(most, std::abs(run.record.energy.total - start));
    turned = std::max(turned, std::abs(run.coordinate("crank_hinge") - 0.9));
    const JointGap gap = gap_at_start(placed(run.scene, run.record), run.scene.loops.front());
    ASSERT_LT(gap.m, 1e-8);
    ASSERT_LT(gap.rad, 1e-7);
  }
  EXPECT_GT(turned, 1);
  EXPECT_LT(most, 1e-3);
  EXPECT_GT(run.record.term_forces.front().f.norm(), 0.1);
}

}  // namespace
}  // namespace godobject::test::test_term_scenes
