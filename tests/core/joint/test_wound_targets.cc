// Targets of bodies on joints are counted as the joints' coordinates are (16). A target turned beyond a stop
// by any number of turns presses the body on it, and brings it back only with its own motion.
#include <iostream>

#include "tests/core/joint/wound_tool.h"

namespace godobject::test_wound_targets {
namespace {

using namespace test_wound;

struct Worst {
  Real depth = 0, torque = 0, shown = 0, rest = 0, back = 0;
  int rests = 0, chatters = 0;
};

template <class S>
void expect_held(unsigned seed, int draws) {
  Random random(seed);
  Worst worst;
  for (int draw = 0; draw < draws; ++draw) {
    const Winding t = Winding::random(random);
    // chatter shakes the other axis of a universal joint
    const Turn& turn = all_turns[static_cast<std::size_t>(t.is_stiff ? draw % 2 : draw % 4)];
    SCOPED_TRACE(testing::Message() << "draw " << draw << ' ' << t);
    auto run = std::make_unique<Wound<S>>();
    run->par.h = t.h;
    run->q_WS = random.rotation();
    run->add(0, turn, t.inertia, t.k_r, t.zeta);
    run->stop(0) = t.stop();
    run->start();
    const Real side = t.end > 0 ? 1 : -1;
    const Real g_r = run->par.bodies[0].coupling.g_r;
    const Real I = turn.axis.dot(run->par.bodies[0].body.I_B * turn.axis);
    // Statics at the largest torque, of spring and damper. The depth of arriving at the target's speed.
    // The way of a step from rest under that torque, without the stop.
    const Real largest = t.k_r * std::abs(t.over) + g_r * std::abs(t.rate);
    const Real inertia = I + t.h * g_r + t.h * t.h * t.k_r;
    const Real bound = t.depth(largest) + std::abs(t.rate) * (std::sqrt(I / t.k) + t.h) + t.width +
                       t.h * t.h * largest / inertia;
    const auto follow = [&](Real rate) {
      run->follow({rate, 0});
      const Real e = run->target[0] - run->q(0);
      worst.depth = std::max(worst.depth, side * (run->q(0) - t.end) / bound);
      worst.torque = std::max(worst.torque, std::abs(run->spring_torque(0).dot(turn.axis) / t.k_r - e));
      worst.shown = std::max(worst.shown, std::abs(run->shown_torque(0).dot(turn.axis) / t.k_r + e));
    };
    for (int n = 0; n < t.steps(); ++n) follow(t.rate);
    for (int n = 0; n < t.steps_at_rest(); ++n) follow(0);
    const Real force = t.k_r * (run->target[0] - run->q(0));
    const Real d = side * (run->q(0) - t.end);
    const Real s = std::min(d, t.width);
    const Real off = std::abs(t.k * s * (d - s / 2) / t.width - side * force) / std::abs(force);
    if (!t.is_stiff) worst.rest = std::max(worst.rest, off), ++worst.rests;
    else worst.chatters += off > 1e-6;
    for (int n = 0; n < t.steps(); ++n) follow(-t.rate);
    for (int n = 0; n < t.steps_at_rest(); ++n) follow(0);
    worst.back = std::max(worst.back, std::abs(run->q(0) - run->target[0]));
    EXPECT_FALSE(run->balance.gains());
    ASSERT_LT(worst.depth, 1);
    ASSERT_LT(worst.torque, 1e-7);
    ASSERT_LT(worst.shown, 1e-7);
    ASSERT_LT(worst.rest, 1e-6);
    ASSERT_LT(worst.back, 1e-3);
  }
  std::cout << S::Integrator::name << ": depth " << worst.depth << " of its bound, spring torque / k_r off "
            << worst.torque << " rad, displayed " << worst.shown << " rad, at rest " << worst.rest
            << " of it (" << worst.rests << " of " << draws << "; " << worst.chatters
            << " stiff ones chatter), back to " << worst.back << " rad\n";
}

template <class I>
class WoundTargets : public ::testing::Test {};
TYPED_TEST_SUITE(WoundTargets, BothIntegrators);

TYPED_TEST(WoundTargets, PressOnTheStopOfASingleBody) { expect_held<Tool<TypeParam, 1>>(1, 60); }
TYPED_TEST(WoundTargets, PressOnTheStopOfABodyInAPack) { expect_held<Tool<TypeParam, 3>>(2, 60); }
TYPED_TEST(WoundTargets, PressOnTheStopOfABodyThatMayTouch) { expect_held<TouchingTool<TypeParam>>(3, 24); }

/// A tool wound by about two turns on its stop, with its scene turned by q_WS.
template <class S>
std::unique_ptr<Wound<S>> wound_tool(const Quat& q_WS = Quat::Identity()) {
  auto run = std::make_unique<Wound<S>>();
  run->q_WS = q_WS;
  run->R_2 = turn_from_z(Vec3(1, 0.5, 0.2)).toRotationMatrix();
  run->add(0, all_turns[0], 1e-3, 5, 1.4);
  run->add(1, all_turns[0], 5e-4, 2, 1.4);
  run->stop(0) = {.lower = -2.967, .upper = 2.967, .k = 200, .g = 0.01, .width = 0.02};
  run->start();
  for (int n = 0; n < 3000; ++n) run->follow({5, 0.2});
  return run;
}

/// Turning the whole scene turns all poses, and changes nothing else.
TYPED_TEST(WoundTargets, AreTheSameInATurnedScene) {
  Random random(8);
  const auto run = wound_tool<Tool<TypeParam, 5>>();
  for (int draw = 0; draw < 4; ++draw) {
    const auto turned = wound_tool<Tool<TypeParam, 5>>(random.rotation());
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(turned->q(i), run->q(i), 1e-9);
      EXPECT_LT((turned->spring_torque(i) - run->spring_torque(i)).norm(), 1e-8);
    }
    EXPECT_NEAR(turned->balance.energy(), run->balance.energy(), 1e-8 * run->balance.energy());
  }
}

/// A device that engages again, at once or after a long gap, begins on the turn nearest to the body.
TYPED_TEST(WoundTargets, AreCountedFromEngaging) {
  for (const bool is_gap : {false, true}) {
    auto run = wound_tool<Tool<TypeParam, 2>>();
    ASSERT_NEAR(run->spring_torque(0).z() / 5, run->target[0] - run->q(0), 1e-9);
    PoseDevice::Input& in = run->in.devices[0];
    (is_gap ? in.valid : in.engaged) = false;
    for (int n = 0; n < 100; ++n) run->step();
    in.valid = in.engaged = true;
    for (int n = 0; n < 3000; ++n) run->follow({0, 0});
    const Real e = run->target[0] - run->q(0);
    EXPECT_LE(std::abs(run->spring_torque(0).z() / 5), pi) << is_gap;
    EXPECT_NEAR(unwrapped(e, run->spring_torque(0).z() / 5), run->spring_torque(0).z() / 5, 1e-9);
    EXPECT_FALSE(run->x.bodies[0].joint.ahead.any());
  }
}

/// States whose targets are a turn apart are different states.
TYPED_TEST(WoundTargets, AreInTheHash) {
  const auto run = wound_tool<Tool<TypeParam, 5>>();
  const std::uint64_t hash = run->hash();
  std::int16_t& turns = run->x.bodies[0].joint.ahead.list[0].turns;
  ASSERT_EQ(turns, 2);
  turns = 3;
  EXPECT_NE(run->hash(), hash);
}

}  // namespace
}  // namespace godobject::test_wound_targets
