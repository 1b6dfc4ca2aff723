// Bodies on joints that touch each other, free bodies and the world.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject::test_touching_joints {
namespace {

using Tool = Articulated<ImplicitEuler, AllJoints>;

template <class I>
class TouchingJointsOf : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(TouchingJointsOf, BothIntegrators);

/// Without contacts, the tree of contacts is the tree of joints: all kinds of joints, stops, and violations.
TEST(TouchingJoints, ToolsByThemselvesMoveAsWithoutContacts) {
  Random random(1);
  Real off = 0, off_force = 0;
  for (int n = 0; n < 200; ++n) {
    const auto tool = std::make_unique<Running<Tool>>();
    const auto pile = std::make_unique<JointedPile>();
    tool->par.num_bodies = pile->par.num_bodies = static_cast<std::size_t>(random.integer(1, 8));
    tool->par.gravity_W = pile->par.gravity_W = 10 * random.direction();
    for (std::size_t i = 0; i < tool->par.num_bodies; ++i) {
      add_random_body(tool->par, i, 0.1, random);
      for (StopParams& stop : tool->par.bodies[i].joint.stop.stops)
        if (random.integer(0, 1) == 0)
          stop = {.lower = -1, .upper = -0.1, .k = random.log_uniform(1, 1e4), .width = 0.01};
    }
    place_randomly(tool->par, tool->x, 0.1, 0, random);
    for (std::size_t i = 0; i < tool->par.num_bodies; ++i) {
      tool->x.bodies[i].x.X_WB.p += 1e-4 * random.vector();
      tool->in.devices[i].engaged = false;
      pile->par.bodies[i].body = tool->par.bodies[i].body;
      pile->par.bodies[i].joint = tool->par.bodies[i].joint;
      pile->x.bodies[i].x = tool->x.bodies[i].x;
    }
    tool->step();
    pile->step();
    ASSERT_FALSE(any(tool->out.fault | pile->out.fault));
    Real speed = 0, force = 0;
    for (std::size_t i = 0; i < tool->par.num_bodies; ++i) {
      speed = std::max({speed, tool->x.bodies[i].x.v_W.norm(), 0.1 * tool->x.bodies[i].x.w_B.norm()});
      const Wrench& F = tool->out.bodies[i].joint.F_C;
      force = std::max({force, F.f.norm(), 10 * F.tau.norm()});
    }
    for (std::size_t i = 0; i < tool->par.num_bodies; ++i) {
      const RigidBodyState &a = pile->at(i), &b = tool->x.bodies[i].x;
      off = std::max({off, (a.v_W - b.v_W).norm() / speed, 0.1 * (a.w_B - b.w_B).norm() / speed});
      const Wrench &F = pile->out.bodies[i].joint.F_C, &G = tool->out.bodies[i].joint.F_C;
      if (force > 0)
        off_force = std::max({off_force, (F.f - G.f).norm() / force, 10 * (F.tau - G.tau).norm() / force});
    }
  }
  std::printf("tools by themselves: off by %.1e of the velocities, %.1e of the forces\n", off, off_force);
  EXPECT_LT(off, 1e-9);
  EXPECT_LT(off_force, 1e-9);
}

/// A brick is thrown at a chain that floats.
TYPED_TEST(TouchingJointsOf, AChainThatIsHitKeepsMomentumAndGainsNoEnergy) {
  for (const JointKind kind : {JointKind::hinge, JointKind::ball, JointKind::fixed}) {
    const auto pile = std::make_unique<JointedPileOf<TypeParam>>();
    pile->add_chain(4, {}, kind);
    const Vec3 half = brick_half;
    pile->add_brick({.X_WB = at(Vec3(0.05, 0.002, 0.03), Vec3(0.3, 0.2, 0.1)),
                     .V_WB = {.w = Vec3(3, -5, 2), .v = Vec3(0.1, 0, -1)}},
                    brick_mass, half);
    const Vec3 first = pile->momentum();
    const Real before = pile->kinetic();
    Real gained = 0, off = 0, allowed = 0;
    std::size_t contacts = 0;
    Drift apart;
    for (int n = 0; n < 300; ++n) {
      pile->step();
      ASSERT_FALSE(any(pile->out.fault));
      contacts += pile->out.contacts.num_contacts;
      allowed += 5 * pile->out.contacts.residual * pile->par.h;
      gained = std::max(gained, pile->kinetic() - before);
      off = std::max(off, (pile->momentum() - first).norm());
      EXPECT_LE(off, allowed + 1e-10 * first.norm());
      apart = worst(apart, pile->joints_apart());
    }
    std::printf(
        "chain of joints %d: %zu contacts, energy %.2e to %.2e J, gained %.1e J; momentum off by %.1e; "
        "joints apart by %.1e m, %.1e rad\n",
        static_cast<int>(kind), contacts, before, pile->kinetic(), gained, off / first.norm(), apart.m,
        apart.rad);
    EXPECT_GT(contacts, 5u);
    EXPECT_LT(gained, 1e-9);
    EXPECT_LT(off, 1e-2 * first.norm());
    EXPECT_LT(apart.m, 1e-5);
    EXPECT_LT(apart.rad, 1e-3);
  }
}

/// Over two bricks that stand apart on a floor; then another brick falls on it.
TYPED_TEST(TouchingJointsOf, AChainComesToRestOnBricks) {
  const auto pile = std::make_unique<JointedPileOf<TypeParam>>();
  pile->add_floor();
  pile->add_chain(4, {.X_WB = at(Vec3(-0.05, 0, 0.0165)), .V_WB = {}});
  pile->add_brick({.X_WB = at(Vec3(-0.05, 0, 0.005)), .V_WB = {}});
  pile->add_brick({.X_WB = at(Vec3(0.04, 0, 0.005)), .V_WB = {}});
  pile->add_brick({.X_WB = at(Vec3(-0.01, 0, 0.06), Vec3(0, 0.3, 0)), .V_WB = {}});
  ASSERT_TRUE(pile->run(2));
  const std::vector<Vec3> there = pile->positions();
  ASSERT_TRUE(pile->run(1));
  Real unbalanced = 0;
  for (std::size_t i = 0; i < pile->par.num_bodies; ++i)
    unbalanced = std::max(unbalanced, pile->unbalanced(i).f.norm());
  const Drift apart = pile->joints_apart();
  std::printf(
      "chain on bricks: kinetic energy %.1e J, drift %.1e m/s, unbalanced %.1e N, joints apart by %.1e m, "
      "%.1e rad\n",
      pile->kinetic(), pile->drift_since(there), unbalanced, apart.m, apart.rad);
  EXPECT_LT(pile->kinetic(), 1e-9);
  EXPECT_LT(pile->drift_since(there), 1e-5);
  EXPECT_LT(unbalanced, 1e-3);
  EXPECT_LT(apart.m, 1e-8);
  EXPECT_LT(apart.rad, 1e-8);
}

TYPED_TEST(TouchingJointsOf, AGripperHoldsAndLiftsABrick) {
  using Gripper = GripperOf<TypeParam>;
  const auto grip = std::make_unique<Gripper>();
  ASSERT_TRUE(grip->run(0.5));
  const Vec3 held = grip->p(Gripper::brick);
  ASSERT_TRUE(grip->run(1));
  Real unbalanced = 0, torque = 0;
  for (std::size_t i = 0; i < grip->par.num_bodies; ++i) {
    unbalanced = std::max(unbalanced, grip->unbalanced(i).f.norm());
    torque = std::max(torque, grip->unbalanced(i).tau.norm());
  }
  const Real weight = brick_mass * earth_gravity, fall = (grip->p(Gripper::brick) - held).norm();
  const Vec3 F = grip->out.bodies[Gripper::brick].contact.F_W.f;
  std::printf(
      "gripper: the brick slips at %.1e m/s; contacts bear %.6f of its weight; unbalanced %.1e N, %.1e N m; "
      "%d passes, %d iterations, residual %.1e N\n",
      fall, F.z() / weight, unbalanced, torque, grip->out.contacts.newton_iterations,
      grip->out.contacts.iterations, grip->out.contacts.residual);
  EXPECT_NEAR(F.z(), weight, 1e-3 * weight);
  EXPECT_LT(fall, 1e-6);
  EXPECT_LT(unbalanced, 1e-3);
  EXPECT_LT(torque, 1e-5);
  // up by 5 cm in half a second
  const Vec3 from = grip->p(Gripper::brick) - grip->p(Gripper::palm);
  Drift apart;
  for (int n = 1; n <= 500; ++n) {
    grip->lead_to(Gripper::palm, Vec3(0, 0, Gripper::height + 0.025 * (1 - std::cos(pi * n / 500))));
    grip->step();
    ASSERT_FALSE(any(grip->out.fault));
    apart = worst(apart, grip->joints_apart());
  }
  ASSERT_TRUE(grip->run(0.3));
  EXPECT_NEAR(grip->p(Gripper::brick).z(), held.z() + 0.05, 2e-4);
  EXPECT_LT((grip->p(Gripper::brick) - grip->p(Gripper::palm) - from).norm(), 1e-4);
  std::printf("lifted: joints apart by %.1e m, %.1e rad\n", apart.m, apart.rad);
  EXPECT_LT(apart.m, 1e-8);
  EXPECT_LT(apart.rad, 1e-8);
}

/// With nothing to touch, up to fifty radians a step.
TYPED_TEST(TouchingJointsOf, ToolsThatSpinGainNoEnergy) {
  for (const Real h : {1e-3, 5e-3})
    for (const Real spin : {30, 100, 1000, 10000}) {
      Random random(3);
      for (int n = 0; n < 20; ++n) {
        const auto pile = std::make_unique<JointedPileOf<TypeParam>>();
        pile->par.h = h;
        pile->par.num_bodies = static_cast<std::size_t>(random.integer(2, 8));
        for (std::size_t i = 0; i < pile->par.num_bodies; ++i) add_random_body(pile->par, i, 0.1, random);
        place_randomly(pile->par, pile->x, 0.1, spin, random);
        for (auto& device : pile->in.devices) device.engaged = false;
        const Real first = pile->kinetic();
        for (int step = 0; step < 200; ++step) {
          pile->step();
          ASSERT_LE(pile->kinetic(), first * (1 + 1e-6))
              << "tool " << n << " at " << spin << " rad/s, " << h << " s, step " << step;
        }
      }
    }
}

/// Closed by the device, with any body between.
TYPED_TEST(TouchingJointsOf, ImposedJawsCloseOnABrick) {
  using Gripper = GripperOf<TypeParam>;
  const auto grip = std::make_unique<Gripper>();
  for (const std::size_t jaw : {1, 2}) {
    grip->par.bodies[jaw].coupling = {};
    grip->par.bodies[jaw].joint.motion.prescribed = true;
  }
  constexpr Real approach = 2e-3;
  for (int n = 0; n < 500; ++n) {
    const Real q = approach * std::min(n / 200.0, 1.0);
    grip->in.joints[1].q[0] = -q;
    grip->in.joints[2].q[0] = q;
    grip->step();
    ASSERT_FALSE(any(grip->out.fault));
  }
  const Vec3 F = grip->out.bodies[Gripper::brick].contact.F_W.f;
  EXPECT_NEAR(F.z(), brick_mass * earth_gravity, 1e-4);
  for (const std::size_t jaw : {1, 2}) {
    const Real q = HingeJoint::coordinates(joint_of(grip->par, grip->x, jaw).X)[0];
    EXPECT_NEAR(q, jaw == 1 ? -approach : approach, 1e-7);
  }
}

}  // namespace
}  // namespace godobject::test_touching_joints
