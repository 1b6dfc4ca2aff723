// Bounded, finite and dissipative, whatever the stiffness, damping, mass, inertia and step.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/core/one_body.h"
#include "tests/support/share.h"

namespace godobject::test_stability {
namespace {

/// One case of the sweep. The damping ratio is g / sqrt(m k), and g_r / sqrt(I_max k_r).
struct Case {
  Real h, m, k, k_r, zeta, zeta_r;
  Mat3 I_B;
  Vec3 moments;  // principal moments of I_B
  Start start;   // of the body
  Target target;
  Vec3 gravity_W = Vec3::Zero();
};

std::ostream& operator<<(std::ostream& os, const Case& c) {
  return os << "h " << c.h << " m " << c.m << " k " << c.k << " k_r " << c.k_r << " zeta " << c.zeta
            << " zeta_r " << c.zeta_r << " moments " << c.moments.transpose() << "\nI\n"
            << c.I_B << "\nbody at " << c.start.X_WB.p.transpose() << ", q (w x y z) " << c.start.X_WB.q.w()
            << ' ' << c.start.X_WB.q.vec().transpose() << ", v " << c.start.V_WB.v.transpose() << ", w "
            << c.start.V_WB.w.transpose() << "\ntarget at " << c.target.X_WD.p.transpose() << ", q "
            << c.target.X_WD.q.w() << ' ' << c.target.X_WD.q.vec().transpose() << ", w "
            << c.target.V_WD.w.transpose();
}

template <class Integrator>
Running<OneBody<Integrator>> start(const Case& c) {
  Running<OneBody<Integrator>> run;
  run.par.h = c.h;
  run.par.gravity_W = c.gravity_W;
  run.constants().body = rigid_body(c.m, c.I_B);
  run.constants().coupling = {.k = c.k,
                              .g = c.zeta * std::sqrt(c.m * c.k),
                              .k_r = c.k_r,
                              .g_r = c.zeta_r * std::sqrt(c.moments.maxCoeff() * c.k_r)};
  EXPECT_EQ(validate(run.par), Invalid::nothing);
  place(run.x, 0, c.start);
  engage_at(run.x, 0, c.target);
  run.device() = {.target = c.target};
  return run;
}

/// Returns the change of the square root of the energy by rounding of a position of size 1 m and of a
/// quaternion.
Real rounding(const Case& c) {
  const Real length = 1 + c.start.X_WB.p.norm() + c.target.X_WD.p.norm();
  return 1e-15 * (length * std::sqrt(c.k) + 4 * std::sqrt(c.k_r));
}

/// Square root of the energy of body, spring and gravity, zero where they balance.
template <class S>
Real energy_norm(const Running<S>& run) {
  State<S> x = run.x;
  x.bodies[0].x.X_WB.p -= run.par.bodies[0].body.m / run.par.bodies[0].coupling.k * run.par.gravity_W;
  return std::sqrt(run.kinetic() + coupling_at(run.par, x, 0).energy);
}

/// Runs a case whose target rests; fails if energy grows in any step by more than rounding.
template <class Integrator>
::testing::AssertionResult dissipates(const Case& c, int steps) {
  auto run = start<Integrator>(c);
  Real before = energy_norm(run);
  for (int n = 0; n < steps; ++n) {
    run.step();
    const Real after = energy_norm(run);
    if (any(run.out.fault) || !is_finite(run.body()))
      return ::testing::AssertionFailure() << "step " << n << ": not finite\n" << c;
    if (!(after <= before * (1 + Real(5e-10)) + rounding(c)))
      return ::testing::AssertionFailure()
             << "step " << n << ": energy from " << before * before << " to " << after * after << " J\n"
             << c;
    before = after;
  }
  return ::testing::AssertionSuccess();
}

/// Principal moments of a body of size about 0.1 m: ball, rod, plate and an arbitrary tensor, up to `ratio`.
Vec3 moments(int shape, Real m, Real ratio) {
  const Real I = m * 1e-2;
  switch (shape) {
    case 0: return Vec3::Constant(I);
    case 1: return Vec3(I, I, I / ratio);
    case 2: return Vec3(I, Real(0.5) * I, Real(0.5) * I);
    default: return Vec3(I, I / std::sqrt(ratio), I / ratio);
  }
}

constexpr Real half_turn_axis[3] = {0.6, 0, 0.8};

/// A body at rest whose target has jumped by 1 m and half a turn.
Case after_jump() {
  Case c{};
  c.target.X_WD.p = Vec3(0.6, -0.8, 0);
  c.target.X_WD.q = Quat(0, half_turn_axis[0], half_turn_axis[1], half_turn_axis[2]);
  return c;
}

/// Random in all that the issue names; the target rests.
Case random_case(Random& random, Real zeta_min, Real zeta_max) {
  Case c{};
  c.h = random.log_uniform(1e-5, 5e-2);
  c.m = random.log_uniform(1e-6, 1e3);
  c.k = random.log_uniform(1, 1e12);
  c.k_r = random.log_uniform(1e-3, 1e12);
  c.zeta = random.log_uniform(zeta_min, zeta_max);
  c.zeta_r = random.log_uniform(zeta_min, zeta_max);
  c.moments = moments(random.integer(0, 3), c.m, random.log_uniform(1, 1e6));
  c.I_B = random.inertia(c.moments);
  c.start.X_WB = {.p = random.vector(), .q = random.rotation()};
  c.start.V_WB = {.w = random.log_uniform(1e-3, 1e3) * random.direction(),
                  .v = random.log_uniform(1e-3, 1e2) * random.direction()};
  c.target.X_WD = {.p = random.vector(), .q = random.rotation()};
  if (random.integer(0, 3) == 0) {  // half a turn away, exactly or nearly
    const Vec3 u = random.direction();
    const Real near = random.integer(0, 1) * random.uniform(-0.1, 0.1);
    c.target.X_WD.q = c.start.X_WB.q * Quat(std::sin(near), std::cos(near) * u.x(), std::cos(near) * u.y(),
                                            std::cos(near) * u.z());
  }
  return c;
}

/// Random with spring, rotation and step of one order of magnitude, where linearisation is hardest pressed.
Case resonant_case(Random& random, Real zeta_r_min, Real zeta_r_max) {
  Case c = random_case(random, zeta_r_min, zeta_r_max);
  c.moments = moments(random.integer(0, 3), c.m, random.log_uniform(1, 1e3));
  c.I_B = random.inertia(c.moments);
  const Real I = random.integer(0, 1) ? c.moments.maxCoeff() : c.moments.minCoeff();
  c.k_r = random.log_uniform(1e-2, 1e2) * I / (c.h * c.h);
  c.k = random.log_uniform(1e-2, 1e2) * c.m / (c.h * c.h);
  c.start.V_WB.w = random.log_uniform(1e-2, 10) / c.h * random.direction();
  return c;
}

template <class Integrator>
class Stability : public ::testing::Test {
 protected:
  /// Shows the first few failures, counts them all.
  void expect_dissipates(const Case& c, int steps) {
    if (!share_.takes()) return;
    ++num_cases_;
    const auto result = dissipates<Integrator>(c, steps);
    if (result) return;
    if (++num_failed_ <= 3) ADD_FAILURE() << Integrator::name << ": " << result.message();
  }
  void TearDown() override {
    std::cout << Integrator::name << ": " << num_cases_ << " cases, " << num_failed_ << " failed\n";
    EXPECT_GT(num_cases_, 0);
    EXPECT_EQ(num_failed_, 0);
  }

  test::Share share_;
  int num_cases_ = 0, num_failed_ = 0;
};

using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Stability, Integrators);

TYPED_TEST(Stability, JumpOfTheTargetOverTheGrid) {
  Random random(1);
  for (const Real h : {1e-5, 1e-4, 1e-3, 1e-2, 5e-2})
    for (const Real m : {1e-6, 1e-3, 1.0, 1e3})
      for (const Real k : {1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12})
        for (const Real zeta : {0.1, 0.5, 1.0, 1.4, 2.0, 10.0})
          for (int shape = 0; shape < 4; ++shape) {
            Case c = after_jump();
            c.h = h;
            c.m = m;
            c.k = c.k_r = k;
            c.zeta = c.zeta_r = zeta;
            c.moments = moments(shape, m, 1e6);
            c.I_B = random.integer(0, 1) ? random.inertia(c.moments) : Mat3(c.moments.asDiagonal());
            this->expect_dissipates(c, 200);
          }
}

TYPED_TEST(Stability, RandomAtTheDampingOfThePaper) {
  Random random(2);
  for (int i = 0; i < 6000; ++i) this->expect_dissipates(random_case(random, 1.4, 2), 300);
}

TYPED_TEST(Stability, RandomAtAnyDamping) {
  Random random(3);
  for (int i = 0; i < 6000; ++i) this->expect_dissipates(random_case(random, 0.1, 10), 300);
}

TYPED_TEST(Stability, RandomWhereNothingIsSmall) {
  Random random(4);
  for (int i = 0; i < 20000; ++i) this->expect_dissipates(resonant_case(random, 0.1, 10), 100);
}

TYPED_TEST(Stability, RandomInAFieldOfGravity) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    Case c = resonant_case(random, 0.1, 10);
    c.gravity_W = 9.81 * random.direction();
    this->expect_dissipates(c, 100);
  }
}

/// Without any damping implicit Euler still cannot gain (docs/theory/stage.md).
TEST(StabilityOfImplicitEuler, GainsNothingWithoutDamping) {
  Random random(6);
  test::Share share;
  for (int i = 0; i < 10000; ++i) {
    Case c = i % 2 == 0 ? random_case(random, 1, 1) : resonant_case(random, 1, 1);
    c.zeta = c.zeta_r = 0;
    if (!share.takes()) continue;
    ASSERT_TRUE(dissipates<ImplicitEuler>(c, 200));
  }
}

/// Without rotational damping the energy error of TR-BDF2 is of second order, not one-sided: it is bounded.
TEST(StabilityOfTrBdf2, StaysWithinABoundWithoutRotationalDamping) {
  Random random(7);
  test::Share share;
  Real worst = 0;
  for (int i = 0; i < 3000; ++i) {
    Case c = resonant_case(random, 1, 1);
    c.zeta = c.zeta_r = 0;
    c.start.X_WB.p = c.target.X_WD.p;
    c.start.V_WB.v.setZero();
    if (!share.takes()) continue;
    auto run = start<TrBdf2>(c);
    const Real energy = run.energy();
    for (int n = 0; n < 1000; ++n) {
      run.step();
      worst = std::max(worst, run.energy() / energy);
    }
  }
  std::cout << "TR-BDF2, no rotational damping: energy at most " << worst << " of the first\n";
  EXPECT_LT(worst, 1.05);
}

/// A target that moves on a circle of 1 m and spins, 1000 rad/s each: up to 8 turns in a step of 50 ms.
TYPED_TEST(Stability, SpinningAndCirclingTargetLeavesTheBodyBounded) {
  constexpr Real spin = 1000;
  Random random(8);
  for (int i = 0; i < 4000; ++i, ++this->num_cases_) {
    Case c = random_case(random, 1.4, 2);
    c.start.V_WB = {};
    const Vec3 axis_W = random.direction();
    if (!this->share_.takes()) continue;
    auto run = start<TypeParam>(c);
    const Real drift = 2 * run.constants().coupling.g / c.k * spin;  // where the damper drags a body to
    const Real anisotropy = std::sqrt(c.moments.maxCoeff() / c.moments.minCoeff());
    for (int n = 1; n <= 300; ++n) {
      const Eigen::AngleAxis<Real> turn(spin * n * c.h, axis_W);
      const Vec3 arm_W = turn * axis_W.unitOrthogonal();
      run.device().target.X_WD = {.p = arm_W, .q = Quat(turn) * c.target.X_WD.q};
      run.device().target.V_WD = {.w = spin * axis_W, .v = spin * axis_W.cross(arm_W)};
      run.step();
      ASSERT_FALSE(any(run.out.fault)) << c;
      ASSERT_LT(run.body().w_B.norm(), 2 * anisotropy * (spin + pi / c.h)) << TypeParam::name << '\n' << c;
      ASSERT_LT(run.body().X_WB.p.norm(), 20 + drift) << TypeParam::name << " step " << n << "\n" << c;
    }
  }
}

/// A target thrown about at random, samples lost at random: nothing grows.
TYPED_TEST(Stability, ErraticTargetLeavesTheBodyBounded) {
  Random random(9);
  for (int i = 0; i < 2000; ++i, ++this->num_cases_) {
    Case c = random_case(random, 1.4, 2);
    c.start.V_WB = {};
    auto run = start<TypeParam>(c);
    if (!this->share_.takes()) continue;
    run.constants().device.lost = 1e9;  // a gap that ends the engagement would let the body fly
    for (int n = 0; n < 300; ++n) {
      run.device().target.X_WD = {.p = 2 * random.direction(), .q = random.rotation()};
      run.device().target.V_WD = {};
      run.device().valid = random.integer(0, 3) > 0;
      run.step();
      ASSERT_FALSE(any(run.out.fault)) << c;
      ASSERT_LT(run.body().v_W.norm(), 10 / c.h) << TypeParam::name << " step " << n << "\n" << c;
      ASSERT_LT(run.body().X_WB.p.norm(), 20) << TypeParam::name << " step " << n << "\n" << c;
    }
  }
}

}  // namespace
}  // namespace godobject::test_stability
