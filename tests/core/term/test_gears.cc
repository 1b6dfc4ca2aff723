// Springs and gears on coordinates of joints (61), against closed forms and in drawn mechanisms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/core/term/mechanism.h"

namespace godobject::test_gears {
namespace {

template <class I, std::size_t N = 6>
struct Geared {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Joints = TreeJoints<JointStops>;
  using Coupling = None;
  using Feedback = None;
  using Contacts = BodyContacts<4, 2, 16>;
  using Terms = TermList<CoordinateSprings<8>, ConstantForces<2>>;
};

template <class I>
using Mechanism = Running<Geared<I>>;

template <class S>
void start(Running<S>& run, Real h) {
  run.par.h = h;
  ASSERT_EQ(validate(run.par), Invalid::nothing);
  start_turns(run.par, run.x);
}

Mat3 inertia(Real I) { return Vec3(I, I, I).asDiagonal(); }

/// Damped oscillator I q'' + g q' + k q = 0 from q_0 at rest.
struct Oscillator {
  Real I, g, k, q_0;
  Real q(Real t) const {
    const Real d = g / (2 * I), omega = std::sqrt(k / I - d * d);
    return q_0 * std::exp(-d * t) * (std::cos(omega * t) + d / omega * std::sin(omega * t));
  }
  Real acceleration(Real t) const {
    const Real e = 1e-5;
    return (q(t + e) - 2 * q(t) + q(t - e)) / (e * e);
  }
};

constexpr Real T = 0.2;

struct GearError {
  Real q = 0, deviation = 0, torque = 0;
};

/// Two wheels of 2e-5 and 7e-5 kg m^2 with a spring on the first, and a gear of ratio -1.7.
template <class I>
GearError wheels(Real h) {
  constexpr Real I_a = 2e-5, I_b = 7e-5, ratio = -1.7, k = 0.3, g = 2e-3, q_0 = 0.4, offset = 0.25;
  auto run = std::make_unique<Mechanism<I>>();
  run->par.num_bodies = 0;
  add_body(*run, 0.05, inertia(I_a), JointKind::hinge, world, {}, q_0);
  add_body(*run, 0.08, inertia(I_b), JointKind::hinge, world,
           {.p = Vec3(0.1, 0, 0), .q = exp_so3(Vec3(0.7, -0.3, 0.2))}, ratio * q_0 + offset);
  add_spring(*run, joint_spring(0, k, g));
  add_spring(*run, gear(0, 1, ratio, offset));
  start(*run, h);
  const Oscillator exact{I_a + ratio * ratio * I_b, g, k, q_0};
  GearError worst;
  const auto steps = std::lround(T / h);
  for (long n = 1; n <= steps; ++n) {
    run->step();
    EXPECT_EQ(run->out.fault, Fault::none);
    const Real q_a = run->x.bodies[0].joint.q[0], q_b = run->x.bodies[1].joint.q[0];
    const Real t = static_cast<Real>(n) * h;
    worst.q = std::max(worst.q, std::abs(q_a - exact.q(t)));
    worst.deviation = std::max(worst.deviation, std::abs(q_b - ratio * q_a - offset));
    // mean torque of the gear on the second wheel over the step
    const Vec3 tau = run->out.terms.list[1].tau;
    if (n > 2)
      worst.torque = std::max(worst.torque,
                              std::abs(tau.norm() - std::abs(I_b * ratio * exact.acceleration(t - h / 2))));
  }
  return worst;
}

template <class I>
void expect_wheels(Real least_order) {
  const GearError e_1 = wheels<I>(1e-3), e_2 = wheels<I>(5e-4);
  std::printf("%s: coordinate %.1e, %.1e rad, deviation %.1e, %.1e rad, torque %.1e, %.1e N m\n", I::name,
              e_1.q, e_2.q, e_1.deviation, e_2.deviation, e_1.torque, e_2.torque);
  EXPECT_GT(std::log2(e_1.q / e_2.q), least_order);
  EXPECT_LT(e_1.deviation, 1e-7);
  EXPECT_GT(std::log2(e_1.torque / e_2.torque), least_order - 0.1);
}

TEST(Gears, TurnWheelsAsOneOscillator) {
  expect_wheels<ImplicitEuler>(0.9);
  expect_wheels<TrBdf2>(1.9);
}

/// A rack of 0.2 kg falls and turns its pinion: q'' = g / (1 + I / (m r^2)).
template <class I>
void expect_rack(Real tolerance) {
  constexpr Real m = 0.2, I_p = 4e-5, r = 0.012, h = 1e-3;
  auto run = std::make_unique<Mechanism<I>>();
  run->par.num_bodies = 0;
  run->par.gravity_W = Vec3(0, 0, -9.81);
  add_body(*run, 0.05, inertia(I_p), JointKind::hinge, world,
           {.p = Vec3(r, 0, 0), .q = exp_so3(Vec3(pi / 2, 0, 0))});
  add_body(*run, m, inertia(1e-4), JointKind::slider, world, {});
  add_spring(*run, gear(0, 1, r));
  start(*run, h);
  run->step(300);
  const Real t = 0.3, a = -9.81 / (1 + I_p / (m * r * r));
  EXPECT_NEAR(run->x.bodies[1].joint.q[0], a * t * t / 2, tolerance) << I::name;
  EXPECT_NEAR(run->x.bodies[0].joint.q[0], run->x.bodies[1].joint.q[0] / r, 1e-8) << I::name;
  EXPECT_GT(std::abs(run->x.bodies[0].joint.q[0]), 2 * pi) << "turns are counted";
  EXPECT_NEAR(run->out.terms.list[0].f.z(), m * (a + 9.81), 1e-5) << "of the teeth on the rack";
}

TEST(Gears, RackTurnsPinion) {
  expect_rack<ImplicitEuler>(2e-3);  // of first order
  expect_rack<TrBdf2>(1e-5);
}

/// One handle drives both blades of scissors; the hand bears both springs.
template <class I>
void expect_scissors() {
  constexpr Real k = 0.05, q = 0.3;
  auto run = std::make_unique<Mechanism<I>>();
  run->par.num_bodies = 0;
  add_body(*run, 0.1, inertia(1e-5), JointKind::hinge, world, {}, q);
  add_body(*run, 0.02, inertia(2e-6), JointKind::hinge, world, {.p = Vec3(0.1, 0, 0)}, q / 2);
  add_body(*run, 0.02, inertia(2e-6), JointKind::hinge, world, {.p = Vec3(0.1, 0, 0)}, -q / 2);
  add_spring(*run, gear(0, 1, 0.5));
  add_spring(*run, gear(0, 2, -0.5));
  add_spring(*run, joint_spring(1, k, 0));
  add_spring(*run, joint_spring(2, k, 0));
  add_spring(*run, joint_spring(0, 100, 0.1, q));  // the hand, stiff
  start(*run, 1e-3);
  run->step(2000);
  // k q / 2 on each blade, by 1 / 2 each at the handle
  const Real at_hand = 100 * (run->x.bodies[0].joint.q[0] - q);
  EXPECT_NEAR(at_hand, -k * q / 2, 1e-5) << I::name;
  EXPECT_NEAR(run->out.terms.list[0].tau.z(), k * q / 2, 1e-5) << I::name;
  EXPECT_NEAR(run->x.bodies[1].joint.q[0], -run->x.bodies[2].joint.q[0], 1e-9) << I::name;
}

TEST(Gears, OneHandleDrivesBothBlades) {
  expect_scissors<ImplicitEuler>();
  expect_scissors<TrBdf2>();
}

/// A chain on joints of drawn kinds, with springs and gears between drawn coordinates.
template <class I>
struct Drawn {
  std::unique_ptr<Mechanism<I>> run = std::make_unique<Mechanism<I>>();

  explicit Drawn(unsigned seed) {
    Random random(seed);
    draw_gears(*run, random);
    start(*run, random.log_uniform(1e-4, 4e-3));
  }
};

template <class I>
void expect_no_gain() {
  Real apart = 0, drifted = 0;
  std::vector<Real> all;
  int gains = 0;
  for (unsigned seed = 0; seed < 150; ++seed) {
    Drawn<I> drawn(seed);
    auto& run = *drawn.run;
    EnergyBalance<Geared<I>> balance;
    balance.start(run.par, run.x);
    for (int n = 0; n < 500; ++n) {
      run.step();
      ASSERT_EQ(run.out.fault, Fault::none) << I::name << ", seed " << seed << ", step " << n;
      balance.observe(run.par, run.x, run.w, run.out);
      gains += balance.watch().gains() ? 1 : 0;
    }
    const CoordinateSpringParams& rigid = run.par.terms.template of<0>().list[6];
    const Real at_end = std::abs(CoordinateSprings<8>::deviation(rigid, TermPlaces<Geared<I>>{run.x}));
    apart = std::max(apart, at_end);
    all.push_back(at_end);
    drifted = std::max(drifted, drift(run.par, run.x).m);
  }
  std::sort(all.begin(), all.end());
  std::printf(
      "%s: 150 mechanisms, gears apart by %.1e in the median, %.1e at most, joints by %.1e m, %d gain\n",
      I::name, all[all.size() / 2], apart, drifted, gains);
  EXPECT_EQ(gains, 0) << I::name;
  EXPECT_LT(apart, 1e-5) << I::name;
}

TEST(Gears, NeverGainInDrawnMechanisms) {
  expect_no_gain<ImplicitEuler>();
  expect_no_gain<TrBdf2>();
}

/// Momentum stays: a gear between parts of a free body turns it back.
TEST(Gears, KeepAngularMomentum) {
  auto run = std::make_unique<Mechanism<TrBdf2>>();
  run->par.num_bodies = 0;
  add_body(*run, 0.3, inertia(1e-4), JointKind::free, world, {});
  add_body(*run, 0.1, inertia(2e-5), JointKind::hinge, 0, {.p = Vec3(0.05, 0, 0)}, 0.2);
  add_body(*run, 0.1, inertia(3e-5), JointKind::hinge, 0, {.p = Vec3(-0.05, 0.01, 0)}, -0.4);
  add_spring(*run, gear(1, 2, -2));
  add_spring(*run, joint_spring(1, 0.5, 0));
  start(*run, 1e-3);
  const auto momentum = [&] {
    Vec3 L = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const RigidBodyState& x = run->x.bodies[i].x;
      L += to_world(x.X_WB.q, run->par.bodies[i].body.I_B * x.w_B) +
           run->par.bodies[i].body.m * x.X_WB.p.cross(x.v_W);
    }
    return L;
  };
  Real most = 0, turned = 0;
  for (int n = 0; n < 300; ++n) {
    run->step();
    most = std::max(most, momentum().norm());
    turned = std::max(turned, std::abs(run->x.bodies[0].x.w_B.z()) * 1e-4);
  }
  EXPECT_GT(turned, 1e-6);
  EXPECT_LT(most, 1e-6 * turned);
}

TEST(Gears, AreChecked) {
  const auto validated = [](auto change) {
    auto run = std::make_unique<Mechanism<TrBdf2>>();
    run->par.num_bodies = 0;
    add_body(*run, 0.1, inertia(1e-4), JointKind::hinge, world, {});
    add_body(*run, 0.1, inertia(1e-4), JointKind::ball, 0, {});
    change(add_spring(*run, joint_spring(0, 1, 0)));
    return validate(run->par);
  };
  EXPECT_EQ(validated([](CoordinateSpringParams&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](CoordinateSpringParams& p) { p.of[0].c = 1; }), Invalid::term);
  EXPECT_EQ(validated([](CoordinateSpringParams& p) { p.of[0].body = 1; }), Invalid::term)
      << "a ball has none";
  EXPECT_EQ(validated([](CoordinateSpringParams& p) { p.of[0].body = 7; }), Invalid::term);
  EXPECT_EQ(validated([](CoordinateSpringParams& p) { p.k = -1; }), Invalid::term);
  EXPECT_EQ(validated([](CoordinateSpringParams& p) {
              p.size = 2;
              p.of[1] = p.of[0];
            }),
            Invalid::term);
  EXPECT_EQ(validated([](CoordinateSpringParams& p) { p.y_0 = NAN; }), Invalid::term);
}

}  // namespace
}  // namespace godobject::test_gears
