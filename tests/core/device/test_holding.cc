// Grab and release: a device grips moving bodies and releases them.
#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_holding {
namespace {

/// Bodies that one device may hold, of 0.1 kg on the coupling of the demo.
template <class IntegratorPart, std::size_t N>
struct HeldBodies {
  static constexpr std::size_t max_bodies = N;
  using Integrator = IntegratorPart;
  using Device = HoldingDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;
};

/// The hand: a wide motion of all six coordinates, and its exact velocity.
struct Hand {
  Vec3 amplitude{0.2, 0.15, 0.1}, frequency_hz{0.5, 0.7, 0.9};
  Vec3 axis = Vec3(1, -2, 2) / 3;
  Real swing = 2.5, swing_hz = 0.4;  // of the attitude, rad

  Target at(Real t) const {
    const Vec3 w = 2 * pi * frequency_hz, angle = t * w;
    const Real w_swing = 2 * pi * swing_hz;
    const Vec3 p = amplitude.cwiseProduct(angle.array().sin().matrix());
    const Vec3 v = amplitude.cwiseProduct(w).cwiseProduct(angle.array().cos().matrix());
    return {.X_WD = {.p = p, .q = exp_so3(Vec3(swing * std::sin(w_swing * t) * axis))},
            .V_WD = {.w = swing * w_swing * std::cos(w_swing * t) * axis, .v = v}};
  }
};

template <class IntegratorPart, std::size_t N = 1>
struct Game {
  using S = HeldBodies<IntegratorPart, N>;
  Params<S> par;
  State<S> x;
  Scratch<S> w;
  Input<S> in;
  Output<S> out;
  Hand hand;

  explicit Game(Real h = 1e-3, Real rise = 0.05) {
    par.h = h;
    par.num_bodies = N;
    for (auto& body : par.bodies) {
      body.body = rigid_body(0.1, Vec3(3.5e-4, 2e-4, 1e-4).asDiagonal().toDenseMatrix());
      body.coupling = {.k = 1000, .g = 14, .k_r = 2, .g_r = 0.04};
      body.feedback.gains = {.k = 500, .g = 1, .k_r = 1, .g_r = 0.01};
      body.device.rise = rise;
    }
    EXPECT_EQ(validate(par), Invalid::nothing);
    hold_nothing();
  }

  Real time() const { return par.h * static_cast<Real>(x.tick); }
  void hold_nothing() {
    for (auto& device : in.devices) device.engaged = false;
  }
  void hold(std::size_t i) {
    hold_nothing();
    in.devices[i].engaged = true;
  }
  /// One step towards the hand at its end.
  void step(bool valid = true) {
    const Target sample = hand.at(time() + par.h);
    for (auto& device : in.devices) {
      device.target = sample;
      device.valid = valid;
    }
    godobject::step(par, in, x, w, out);
    ASSERT_FALSE(any(out.fault));
  }
  void run(Real seconds) {
    for (std::int64_t n = std::llround(seconds / par.h); n > 0; --n) step();
  }
  RigidBodyState& body(std::size_t i = 0) { return x.bodies[i].x; }
  Vec3 w_W(std::size_t i = 0) { return to_world(body(i).X_WB.q, body(i).w_B); }
  Wrench pull(std::size_t i = 0) const { return coupling_at(par, x, i).F_WB; }
  /// The body as the hand sees it.
  Pose grip(std::size_t i = 0) const { return seen_from(hand.at(time()).X_WD, x.bodies[i].x.X_WB); }
};

Real angle_between(const Quat& a, const Quat& b) { return rotation_error(a, b, Vec3::Zero()).phi_B.norm(); }

template <class I>
class Holding : public ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Holding, Integrators);

/// For any poses and velocities of the two: after the step of the capture the target is at the body, and no
/// force has acted. (Freedom of that step: tests/core/device/test_engage.cc.)
TYPED_TEST(Holding, CapturesThePoseAtThatInstant) {
  Random random(3);
  for (int n = 0; n < 200; ++n) {
    Game<TypeParam> game;
    game.x.tick = static_cast<std::uint64_t>(random.integer(0, 5000));
    const Twist V{.w = 20 * random.vector(), .v = 2 * random.direction()};
    place(game.x, 0, {.X_WB = {.p = random.vector(), .q = random.rotation()}, .V_WB = V});
    game.step();
    game.hold(0);
    game.step();
    const Target& target = game.x.bodies[0].device.last;
    const Real w_sq = V.w.squaredNorm(), h = game.par.h;
    EXPECT_LE((target.X_WD.p - game.body().X_WB.p).norm(), 1e-13);
    EXPECT_LE(angle_between(target.X_WD.q, game.body().X_WB.q), 4 * h * h * w_sq);  // gyroscopic torque
    EXPECT_EQ(game.pull().f.norm() + game.pull().tau.norm(), 0);
  }
}

/// Largest values while a body of 2 m/s and 20 rad/s is gripped, carried and gripped once more, half a second
/// each.
struct Largest {
  Real df = 0, dtau = 0;  // change of the pull from step to step, N, N m
};

template <class I>
Largest largest(Real h, Real rise = 0.05) {
  Game<I> game(h, rise);
  place(game.x, 0,
        {.X_WB = {.p = Vec3(0.1, 0.3, 0), .q = Quat(0.5, 0.5, -0.5, 0.5)},
         .V_WB = {.w = Vec3(8, 16, -8), .v = Vec3(2, 0, 0)}});
  Largest most;
  for (int round = 0; round < 3; ++round) {
    game.hold_nothing();
    game.run(0.1);
    game.hold(0);
    Wrench before;
    for (std::int64_t n = std::llround(0.5 / h); n > 0; --n) {
      game.step();
      const Wrench now = game.pull();
      most.df = std::max(most.df, (now.f - before.f).norm());
      most.dtau = std::max(most.dtau, (now.tau - before.tau).norm());
      before = now;
    }
  }
  return most;
}

TYPED_TEST(Holding, ThePullRisesContinuously) {
  const Largest coarse = largest<TypeParam>(1e-3), fine = largest<TypeParam>(0.25e-3);
  EXPECT_NEAR(coarse.df / fine.df, 4, 0.5)
      << coarse.df << " " << fine.df;  // of order h, as of any continuous force
  EXPECT_NEAR(coarse.dtau / fine.dtau, 4, 0.5) << coarse.dtau << " " << fine.dtau;
  EXPECT_GT(largest<TypeParam>(1e-3, 0).df, 10 * coarse.df);  // purpose of the ramp: the full damper at once
}

TYPED_TEST(Holding, ABodyHeldAtRestStays) {
  Game<TypeParam> game;
  game.hand.frequency_hz.setZero();
  game.hand.swing = 0;
  const Pose start{.p = Vec3(0.3, -0.2, 0.1), .q = Quat(0.1, 0.7, -0.5, 0.5).normalized()};
  place(game.x, 0, {.X_WB = start, .V_WB = {}});
  game.hold(0);
  game.run(5);
  EXPECT_LE((game.body().X_WB.p - start.p).norm(), 1e-14);
  EXPECT_LE(angle_between(game.body().X_WB.q, start.q), 1e-14);
}

TYPED_TEST(Holding, AFastSpinningBodyComesToRestInTheHandWhereItWasTaken) {
  Game<TypeParam> game;
  game.hand.frequency_hz.setZero();
  game.hand.swing_hz = 0;
  place(game.x, 0,
        {.X_WB = {.p = Vec3(0.1, 0, 0), .q = Quat(0, 1, 0, 0)},
         .V_WB = {.w = Vec3(0, 15, 15), .v = Vec3(-2, 0, 0)}});
  game.hold(0);
  game.step();
  const Pose taken = game.x.bodies[0].device.X_DB;
  game.run(0.05);
  EXPECT_GT((game.grip().p - taken.p).norm(), 0.01);  // swept on by its momentum
  game.run(2);
  EXPECT_LE((game.grip().p - taken.p).norm(), 1e-9);
  EXPECT_LE(angle_between(game.grip().q, taken.q), 1e-9);
  EXPECT_LE(game.body().v_W.norm() + game.body().w_B.norm(), 1e-8);
}

/// Carried far from the hand it swings with it: the target's velocity is the rate of its pose.
TYPED_TEST(Holding, TheTargetMovesAsAPointOfTheHand) {
  Game<TypeParam> game;
  place(game.x, 0, {.X_WB = {.p = Vec3(0.5, -0.3, 0.4), .q = Quat(0.5, -0.5, 0.5, 0.5)}, .V_WB = {}});
  game.hold(0);
  game.run(0.4);
  const Real h = game.par.h;
  for (int n = 0; n < 1000; ++n) {
    const Target a = game.x.bodies[0].device.last;
    game.step();
    const Target b = game.x.bodies[0].device.last;
    const Vec3 v = (b.X_WD.p - a.X_WD.p) / h,
               w = to_world(a.X_WD.q, rotation_error(a.X_WD.q, b.X_WD.q, Vec3::Zero()).phi_B) / h;
    EXPECT_LE((v - 0.5 * (a.V_WD.v + b.V_WD.v)).norm(), 1e-4);  // h^2 / 12 of the third derivative
    EXPECT_LE((w - 0.5 * (a.V_WD.w + b.V_WD.w)).norm(), 1e-4);
    EXPECT_LE((game.body().X_WB.p - b.X_WD.p).norm(), 0.02);
  }
}

/// Throwing: in the step of the release the body goes on as it did, with the velocity of its place in the
/// hand.
TYPED_TEST(Holding, ReleaseLeavesTheBodyItsVelocity) {
  for (const Real held : {0.02, 0.7, 1.1, 1.6}) {
    Game<TypeParam> game;
    place(game.x, 0, {.X_WB = {.p = Vec3(0.2, 0, 0.1), .q = Quat(0.5, 0.5, 0.5, 0.5)}, .V_WB = {}});
    game.hold(0);
    game.run(held);
    const RigidBodyState before = game.body();
    const Vec3 w_W = game.w_W();
    const Target place_in_hand = game.x.bodies[0].device.last;
    game.hold_nothing();
    game.step();
    const Real h = game.par.h;
    EXPECT_LE((game.body().v_W - before.v_W).norm(), 1e-14);
    EXPECT_LE((game.body().X_WB.p - before.X_WB.p - h * before.v_W).norm(), 1e-14);
    EXPECT_LE((game.w_W() - w_W).norm(), 2 * h * w_W.squaredNorm());  // gyroscopic torque
    if (held > 0.5) {
      EXPECT_GT(before.v_W.norm(), 0.3) << "not in mid-motion";
      EXPECT_LE((before.v_W - place_in_hand.V_WD.v).norm(), 0.1);  // it follows, damped, within its mass
    }
  }
}

/// A hand that holds nothing is no part of the world.
TYPED_TEST(Holding, BetweenTwoHoldsTheDeviceDrivesNothing) {
  const Start start{.X_WB = {.p = Vec3(0.1, 0.2, 0.3), .q = Quat(0.5, 0.5, 0.5, 0.5)},
                    .V_WB = {.w = Vec3(3, 4, 5), .v = Vec3(1, 2, 3)}};
  Game<TypeParam> game;
  Running<OneBody<TypeParam, None, None>> free;
  free.constants().body = game.par.bodies[0].body;
  place(game.x, 0, start);
  place(free.x, 0, start);
  for (int n = 0; n < 500; ++n) {
    game.step(n % 5 != 0);
    free.step();
  }
  EXPECT_EQ(game.body().X_WB.p, free.body().X_WB.p);
  EXPECT_LE((game.body().X_WB.q.coeffs() - free.body().X_WB.q.coeffs()).norm(), 1e-12);
  EXPECT_EQ(game.pull().f.norm() + game.pull().tau.norm() + game.out.bodies[0].feedback.F_D.f.norm(), 0);
}

/// Samples lost while holding: as for a device of absolute pose at the body's place in the hand.
TYPED_TEST(Holding, ALostSampleIsThatOfAPoseDevice) {
  Game<TypeParam> game;
  place(game.x, 0, {.X_WB = {.p = Vec3(0.2, 0, 0.1), .q = Quat(0.5, 0.5, 0.5, 0.5)}, .V_WB = {}});
  game.hold(0);
  game.run(0.3);
  Running<OneBody<TypeParam, PoseDevice, DampedSpring, LimitedFeedback>> other;
  other.constants().body = game.par.bodies[0].body;
  other.constants().coupling = game.par.bodies[0].coupling;
  other.constants().feedback = game.par.bodies[0].feedback;
  other.constants().device = game.par.bodies[0].device;
  other.x.bodies[0].x = game.x.bodies[0].x;
  other.x.bodies[0].device = game.x.bodies[0].device;
  other.x.bodies[0].coupling = game.x.bodies[0].coupling;
  other.x.bodies[0].feedback = game.x.bodies[0].feedback;
  if constexpr (std::is_same_v<TypeParam, TrBdf2>) other.x.bodies[0].memory = game.x.bodies[0].memory;
  const Pose X_DB = game.x.bodies[0].device.X_DB;
  for (int n = 0; n < 2000; ++n) {
    const bool valid = n % 97 > n % 3;  // up to 3 lost in a row, which are bridged
    game.step(valid);
    const Target sample = game.hand.at(game.time());
    other.device().target.X_WD = sample.X_WD * X_DB;
    other.device().target.V_WD = {.w = sample.V_WD.w,
                                  .v = sample.V_WD.v + sample.V_WD.w.cross(to_world(sample.X_WD.q, X_DB.p))};
    other.device().valid = valid;
    other.step();
    ASSERT_EQ(has(game.out.limited, Limited::held), !valid);
    ASSERT_LE((game.body().X_WB.p - other.body().X_WB.p).norm(), 1e-12) << n;
    ASSERT_LE((game.body().v_W - other.body().v_W).norm(), 1e-10) << n;
    ASSERT_LE(angle_between(game.body().X_WB.q, other.body().X_WB.q), 1e-12) << n;
    ASSERT_LE((game.out.bodies[0].feedback.F_D.f - other.out.bodies[0].feedback.F_D.f).norm(), 1e-9) << n;
  }
}

/// After a long gap it grips the body where it is then.
TYPED_TEST(Holding, AfterALongGapItTakesHoldAnew) {
  Game<TypeParam> game;
  place(game.x, 0, {.X_WB = {.p = Vec3(0.2, 0, 0.1), .q = Quat(0.5, 0.5, 0.5, 0.5)}, .V_WB = {}});
  game.hold(0);
  game.run(0.3);
  const Pose first = game.x.bodies[0].device.X_DB;
  for (int n = 0; n < 300; ++n) game.step(false);
  game.x.tick += 700;  // the hand is elsewhere by now
  game.step();
  EXPECT_EQ(game.pull().f.norm(), 0);
  EXPECT_TRUE(has(game.out.limited, Limited::ramp));
  const Pose long_gap = game.x.bodies[0].device.X_DB;
  EXPECT_GT((first.p - long_gap.p).norm(), 0.05);
  EXPECT_LE((long_gap.p - game.grip().p).norm(), 1e-12);
}

/// From one body to another, in one step or with steps between: each is as if the other were not there.
TYPED_TEST(Holding, ChangesFromOneBodyToAnother) {
  for (const int between : {0, 1, 40}) {
    SCOPED_TRACE(between);
    Game<TypeParam, 2> game;
    for (const std::size_t i : {0u, 1u})
      place(game.x, i,
            {.X_WB = {.p = Vec3(0.2 + 0.3 * static_cast<Real>(i), 0.1, 0), .q = Quat(0.5, 0.5, 0.5, 0.5)},
             .V_WB = {.w = Vec3(1, 2, 3), .v = Vec3(0, 0.5, 0)}});
    game.hold(0);
    game.run(0.6);
    EXPECT_LE((game.body(1).v_W - Vec3(0, 0.5, 0)).norm(), 1e-15);  // not held, not driven
    EXPECT_GT(game.out.bodies[0].feedback.F_D.f.norm(), 0.1);
    game.hold_nothing();
    for (int n = 0; n < between; ++n) game.step();
    const Vec3 v_0 = game.body(0).v_W, v_1 = game.body(1).v_W;
    game.hold(1);
    game.step();
    EXPECT_EQ(game.pull(0).f.norm() + game.pull(1).f.norm(), 0);
    EXPECT_LE((game.body(0).v_W - v_0).norm() + (game.body(1).v_W - v_1).norm(), 1e-14);
    game.run(0.6);
    EXPECT_LE((game.body(0).v_W - v_0).norm(), 1e-14);  // flies on
    EXPECT_EQ(game.out.bodies[0].feedback.F_D.f.norm(), 0);
    const Target& target = game.x.bodies[1].device.last;
    EXPECT_LE((game.body(1).X_WB.p - target.X_WD.p).norm(), 0.02);
    EXPECT_LE((game.body(1).v_W - target.V_WD.v).norm(), 0.15);
  }
}

/// The state is all there is: from a copy of it, in the middle of a hold, the same bits follow.
TYPED_TEST(Holding, ReplaysBitForBit) {
  const auto play = [](Game<TypeParam, 2>& game, int from, int to) {
    for (int n = from; n < to; ++n) {
      if (n % 150 == 0) game.hold_nothing();
      if (n % 150 == 60) game.hold(static_cast<std::size_t>(n / 150 % 2));
      game.step(n % 7 != 0);
    }
  };
  Game<TypeParam, 2> game;
  place(game.x, 1, {.X_WB = {.p = Vec3(0.5, 0, 0), .q = Quat(0.5, 0.5, 0.5, 0.5)}, .V_WB = {}});
  play(game, 0, 1000);
  const Game<TypeParam, 2> copy = game;
  play(game, 1000, 2000);
  const std::uint64_t hash = state_hash(game.par, game.x);
  Game<TypeParam, 2> long_gap;
  long_gap.x = copy.x;
  long_gap.in = copy.in;
  play(long_gap, 1000, 2000);
  EXPECT_EQ(state_hash(long_gap.par, long_gap.x), hash);
  long_gap.x.bodies[0].device.X_DB.p.x() += 1e-15;
  EXPECT_NE(state_hash(long_gap.par, long_gap.x), hash) << "the grip is part of the state";
}

}  // namespace
}  // namespace godobject::test_holding
