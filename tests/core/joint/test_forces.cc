// Forces of a grasper at rest and in motion: joint reactions, motor torques by (8) and (9), virtual power.
#include <gtest/gtest.h>

#include "core/godobject.h"
#include "hal/joint/kinematic_tree.h"
#include "tests/core/joint/hung_grasper.h"

namespace godobject::test_forces {
namespace {

constexpr Real tolerance = 1e-9;

TEST(Forces, ReactionsOfAToolThatHangsStraight) {
  HungGrasper tool;
  tool.hold(JointVector::Zero(6).eval(), 4000);
  const Real g = HungGrasper::gravity, k_tube = tool.stiffness(1), k_jaw = tool.stiffness(2);
  const Real weight = (tool.mass(1) + 2 * tool.mass(2)) * g;
  const Real sag = weight / (k_tube + 2 * k_jaw);  // tube and jaws slide down as one
  for (const std::size_t i : {1u, 2u, 3u})
    EXPECT_NEAR(tool.target(i).X_WD.p.z() - tool.body(i).X_WB.p.z(), sag, tolerance) << i;
  // the trocar carries itself; the tube slides, so its joint carries nothing along its axis; a jaw's hinge
  // carries the rest of its own spring
  EXPECT_NEAR(tool.reaction(0).f.z(), tool.mass(0) * g, tolerance);
  EXPECT_NEAR(tool.reaction(1).f.z(), 0, tolerance);
  for (const std::size_t i : {2u, 3u}) {
    EXPECT_NEAR(tool.reaction(i).f.z(), tool.mass(2) * g - k_jaw * sag, tolerance) << i;
    EXPECT_LE(tool.reaction(i).tau.norm(), tolerance) << i;
  }
  // all of the weight is on the insertion's motor
  const JointVector tau = tool.motor_torques();
  EXPECT_NEAR(tau[tool.insertion], -weight, tolerance);
  for (const Eigen::Index j : {0, 1, 3}) EXPECT_NEAR(tau[j], 0, tolerance) << j;
}

TEST(Forces, ReactionsBalanceEveryBodyAtRest) {
  HungGrasper tool;
  JointVector q(6);
  q << 0.4, -0.3, 0.03, 0.7, 0.2, 0.35;
  tool.hold(q, 20000);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LE(tool.body(i).V_WB.v.norm() + tool.body(i).V_WB.w.norm(), 1e-11) << i;  // rounding
    const Wrench rest = tool.unbalanced(i);
    EXPECT_LE(rest.f.norm(), tolerance) << i;
    EXPECT_LE(rest.tau.norm(), tolerance) << i;
    EXPECT_GT(tool.reaction(i).f.norm(), 1e-3) << i;
  }
}

// At rest, by virtual work, motors need the torques that balance the weight of all that a joint moves.
TEST(Forces, MotorTorquesAreThoseThatHoldTheTool) {
  HungGrasper tool;
  JointVector q(6);
  q << 0.4, -0.3, 0.03, 0.7, 0.2, 0.35;
  tool.hold(q, 20000);
  const JointVector by_jacobian = tool.motor_torques();
  const JointVector by_hand = tool.motor_torques_walked_up();
  EXPECT_LE((by_jacobian - by_hand).norm(), tolerance);
  EXPECT_GT(by_jacobian.norm(), 1e-3);

  // (9) in the core: only the trocar's and the jaws' links have motors; the tube's wrench goes to the trocar
  HungGrasper undriven;
  undriven.set_driven(1, false);
  undriven.hold(q, 20000);
  const Wrench tube = tool.feedback(1), trocar = tool.feedback(0);
  const Vec3 arm = tool.target(1).X_WD.p - tool.target(0).X_WD.p;
  EXPECT_LE(undriven.feedback(1).f.norm() + undriven.feedback(1).tau.norm(), 0);
  EXPECT_LE((undriven.feedback(0).f - trocar.f - tube.f).norm(), tolerance);
  EXPECT_LE((undriven.feedback(0).tau - trocar.tau - tube.tau - arm.cross(tube.f)).norm(), tolerance);
  // the joints of the trocar feel the same
  const JointVector moved = undriven.motor_torques();
  for (const Eigen::Index j : {0, 1}) EXPECT_NEAR(moved[j], by_jacobian[j], tolerance) << j;
}

TEST(Forces, PowerOfTheMotorsIsThePowerOfTheCoupling) {
  HungGrasper tool;
  for (int n = 1; n <= 3000; ++n) {
    tool.follow(n);
    Real coupling = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Wrench F = tool.coupling(i);  // on the body, about its origin
      const Target& D = tool.target(i);
      coupling += F.f.dot(D.V_WD.v) + F.tau.dot(D.V_WD.w);
    }
    const Real motors = tool.motor_torques().dot(tool.device_rates());
    EXPECT_NEAR(motors, -coupling, 1e-11 * (1 + std::abs(coupling))) << n;
  }
}

}  // namespace
}  // namespace godobject::test_forces
