// Energy balance (38): no false alarm for any motion of a device with a body, and an alarm for a broken
// solver.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "tests/core/broken.h"
#include "tests/core/one_body.h"
#include "tests/study/joint/tool.h"

namespace godobject::test_energy_balance {
namespace {

/// A body on a device that moves smoothly, with jumps, with gaps, disengaged and engaged.
template <class S>
struct Hand {
  Running<S> run;
  EnergyBalance<S> balance;
  Random random;
  Vec3 amplitude, turn;
  Real hz, jump = 0;

  explicit Hand(unsigned seed) : random(seed) {
    auto& par = run.par;
    par.h = random.log_uniform(2e-4, 5e-3);
    par.gravity_W = Vec3(0, 0, -9.81);
    const Real m = random.log_uniform(1e-3, 10), I = m * random.log_uniform(1e-5, 1e-3);
    auto& body = run.constants();
    body.body = rigid_body(m, random.inertia(I * Vec3(1, random.uniform(1, 3), random.uniform(2, 3))));
    const Real k = random.log_uniform(1, 1e6), k_r = random.log_uniform(1e-3, 1e3);
    Real zeta = random.integer(0, 2) * random.uniform(0.01, 1.5);
    // an undamped oscillation with less than six steps per turn has no energy that can be followed
    if (par.h * par.h * k > m || par.h * par.h * k_r > I) zeta = std::max(zeta, Real(0.01));
    body.coupling = {.k = k, .g = zeta * std::sqrt(m * k), .k_r = k_r, .g_r = zeta * std::sqrt(2 * I * k_r)};
    body.device.rise = random.integer(0, 1) * random.uniform(0, 0.3);
    amplitude = random.log_uniform(1e-3, 0.3) * random.direction();
    turn = random.uniform(0, 1) * random.direction();
    hz = random.log_uniform(0.1, 5);
    place(run.x, 0, {.X_WB = {.p = Vec3::Zero()}, .V_WB = {}});
    balance.start(par, run.x);
  }
  Target target(Real t) const {
    const Real w = 2 * pi * hz, s = std::sin(w * t), ds = w * std::cos(w * t);
    return {.X_WD = {.p = s * amplitude + jump * Vec3::UnitX(), .q = exp_so3(Vec3(s * turn))},
            .V_WD = {.w = ds * turn, .v = ds * amplitude}};
  }
  void step() {
    const Target to = target(static_cast<Real>(run.x.tick + 1) * run.par.h);
    if (random.integer(0, 400) == 0) jump = random.uniform(-0.02, 0.02);
    if (random.integer(0, 600) == 0) run.device().engaged = !run.device().engaged;
    run.device().valid = random.integer(0, 200) != 0;
    run.device().target = to;
    run.step();
    balance.observe(run.par, run.x, run.w, run.out);
  }
};

template <class I>
int count_alarms(unsigned end, Real seconds) {
  int alarms = 0;
  for (unsigned seed = 0; seed < end; ++seed) {
    Hand<OneBody<I>> hand(seed);
    bool alarm = false;
    for (Real t = 0; t < seconds && !alarm; t += hand.run.par.h) {
      hand.step();
      alarm = hand.balance.watch().gains();
    }
    alarms += alarm;
  }
  return alarms;
}

TEST(EnergyBalance, NothingThatADeviceDoesIsAGain) {
  EXPECT_EQ(count_alarms<ImplicitEuler>(300, 4), 0);
  EXPECT_EQ(count_alarms<TrBdf2>(300, 4), 0);
}

// 0.1 % in each step
TEST(EnergyBalance, ABrokenSolverIsFoundWithinASecond) {
  int found = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    Hand<OneBody<Broken<TrBdf2, 1000>, PoseDevice, DampedSpring>> hand(seed);
    hand.run.par.h = 1e-3;
    auto& spring = hand.run.constants().coupling;
    spring.k = std::min(spring.k, 1e5 * hand.run.constants().body.m);  // 20 steps to a turn, or more
    spring.k_r = 0;
    hand.run.constants().coupling.g = hand.run.constants().coupling.g_r = 0;
    hand.amplitude = hand.turn = Vec3::Zero();  // no motion of the hand: an offset start oscillates
    hand.run.body().X_WB.p = Vec3(0.05, 0, 0);
    engage_at(hand.run.x, 0, hand.target(0));
    hand.run.par.gravity_W.setZero();
    hand.balance.start(hand.run.par, hand.run.x);
    for (int n = 0; n < 1000; ++n) {
      hand.run.device().target.X_WD = hand.target(0).X_WD;
      hand.run.step();
      hand.balance.observe(hand.run.par, hand.run.x, hand.run.w, hand.run.out);
    }
    found += hand.balance.watch().gains();
  }
  EXPECT_EQ(found, 50);
}

// a free double pendulum keeps its energy within the order; broken, it does not
TEST(EnergyBalance, OfAJointedTool) {
  const auto swing = [](auto scene) {
    using S = decltype(scene);
    auto run = std::make_unique<Running<S>>();
    run->par.num_bodies = 2;
    run->par.gravity_W = Vec3(0, 0, -9.81);
    for (std::size_t i = 0; i < 2; ++i) {
      run->par.bodies[i].body = rigid_body(0.1, 1e-4 * Mat3::Identity());
      run->par.bodies[i].joint.kind = JointKind::ball;
      run->par.bodies[i].joint.parent = i == 0 ? world : 0;
      run->par.bodies[i].joint.P.p = i == 0 ? Vec3(0, 0, 0) : Vec3(0.05, 0, 0);
      run->par.bodies[i].joint.C.p = Vec3(-0.05, 0, 0);
      place(run->x, i, {.X_WB = {.p = Vec3(0.05 + 0.1 * static_cast<Real>(i), 0, 0)}, .V_WB = {}});
      run->in.devices[i].engaged = false;
    }
    EnergyBalance<S> balance;
    balance.start(run->par, run->x);
    bool gains = false;
    for (int n = 0; n < 5000; ++n) {
      run->step();
      balance.observe(run->par, run->x, run->w, run->out);
      gains = gains || balance.watch().gains();
    }
    return gains;
  };
  EXPECT_FALSE(swing(Articulated<ImplicitEuler>{}));
  EXPECT_FALSE(swing(Articulated<TrBdf2>{}));
  EXPECT_TRUE(swing(Articulated<Broken<TrBdf2, 200>>{}));
}

/// A weight on a hinge with prescribed motion, on a body coupled to the device, against gravity and inertia.
template <class I>
bool gains_with_prescribed_motion(unsigned seed) {
  using S = Articulated<I, TreeJoints<None, PrescribedJoints>>;
  Random random(seed);
  const auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.h = random.log_uniform(2e-4, 2e-3);
  par.num_bodies = 2;
  par.gravity_W = 9.81 * random.direction();
  for (std::size_t i = 0; i < 2; ++i) {
    const Real m = random.log_uniform(0.01, 1);
    par.bodies[i].body = rigid_body(m, random.inertia(1e-3 * m * Vec3(1, 2, 2.5)));
    place<S>(run->x, i, {.X_WB = {.p = static_cast<Real>(i) * Vec3(0.1, 0, 0)}, .V_WB = {}});
    run->in.devices[i].target.X_WD = run->x.bodies[i].x.X_WB;
  }
  const Real k = random.log_uniform(100, 1e4), k_r = 1e-2 * k;
  par.bodies[0].coupling = {.k = k, .g = 1.4 * std::sqrt(k), .k_r = k_r, .g_r = 0.05 * std::sqrt(k_r)};
  auto& joint = par.bodies[1].joint;
  joint.kind = JointKind::hinge;
  joint.parent = 0;
  joint.C.p = Vec3(-0.1, 0, 0);
  joint.motion.prescribed = true;
  EnergyBalance<S> balance;
  balance.start(par, run->x);
  const Real amplitude = random.uniform(0.1, 1.5), w = 2 * pi * random.log_uniform(0.2, 5);
  bool gains = false;
  for (Real t = par.h; t < 3; t += par.h) {
    const bool stops = t > 2;  // at once
    run->in.joints[1].q[0] = amplitude * (1 - std::cos(w * std::min(t, Real(2))));
    run->in.joints[1].q_dot[0] = stops ? 0 : amplitude * w * std::sin(w * t);
    run->step();
    balance.observe(par, run->x, run->w, run->out);
    gains = gains || balance.gains();
  }
  return gains;
}

TEST(EnergyBalance, PrescribedMotionGainsNothing) {
  int alarms = 0, found = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    alarms += gains_with_prescribed_motion<ImplicitEuler>(seed);
    alarms += gains_with_prescribed_motion<TrBdf2>(seed);
    found += gains_with_prescribed_motion<Broken<TrBdf2, 20000>>(seed);
  }
  EXPECT_EQ(alarms, 0);
  std::printf("%d of 40 broken ones found\n", found);
  EXPECT_GT(found, 20);  // couplings and gravity dissipate the gain of the others
}

TEST(EnergyBalance, TheEnergyOfAStopIsTheWorkOfItsTorque) {
  const StopParams stop{.lower = -0.3, .upper = 0.5, .k = 7, .width = 0.02};
  for (const Real q : {0.4, 0.505, 0.52, 0.7, -0.31, -0.5}) {
    const Real dq = 1e-6;
    const Real torque = -(stop_energy(stop, q + dq) - stop_energy(stop, q - dq)) / (2 * dq);
    const Real h = 1e-3;
    EXPECT_NEAR(torque, stop_terms(stop, q, 0, h).tau / h, 1e-6) << q;
  }
}

}  // namespace
}  // namespace godobject::test_energy_balance
