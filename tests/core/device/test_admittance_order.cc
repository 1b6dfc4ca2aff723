// Forces of a hand that change within a step: TR-BDF2 is of second order in them, too.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "tests/core/one_body.h"

namespace godobject::test_admittance_order {
namespace {

/// A body that a hand pushes and turns by sines of its own, perhaps on a spring.
struct Pushed {
  RigidBodyParams body;
  SpringParams coupling;
  Vec3 f, tau;
  Real frequency, phase;

  Wrench hand(Real t) const {
    const Real a = std::sin(2 * pi * frequency * t + phase);
    return {.tau = a * tau, .f = a * f};
  }

  template <class I, class Coupling>
  RigidBodyState after(Real seconds, int steps) const {
    Running<OneBody<I, AdmittanceDevice, Coupling>> run;
    run.par.h = seconds / steps;
    run.constants().body = body;
    run.constants().device.rise = 0;
    if constexpr (uses<Coupling>) run.constants().coupling = coupling;
    place(run.x, 0, {});
    for (int n = 1; n <= steps; ++n) {
      run.device().F_WB = hand(n * run.par.h);
      run.step();
      EXPECT_FALSE(any(run.out.fault));
    }
    return run.body();
  }
};

Real distance(const RigidBodyState& a, const RigidBodyState& b) {
  const Vec3 phi = rotation_error(a.X_WB.q, b.X_WB.q, Vec3::Zero()).phi_B;
  return (a.X_WB.p - b.X_WB.p).norm() + (a.v_W - b.v_W).norm() + phi.norm() + (a.w_B - b.w_B).norm();
}

/// The order between steps of this many and of half and a quarter as long (Richardson).
template <class I, class Coupling>
Real order_of(const Pushed& pushed, int steps) {
  const RigidBodyState coarse = pushed.after<I, Coupling>(0.5, steps),
                       middle = pushed.after<I, Coupling>(0.5, 2 * steps),
                       fine = pushed.after<I, Coupling>(0.5, 4 * steps);
  return std::log2(distance(coarse, middle) / distance(middle, fine));
}

TEST(AdmittanceWithTrBdf2, IsOfSecondOrder) {
  Random random(11);
  Real lowest = 9, highest = 0;
  for (int draw = 0; draw < 40; ++draw) {
    const Real m = random.log_uniform(0.05, 2), I = random.log_uniform(1e-4, 1e-3);
    const Real k = random.log_uniform(1, 50) * m, k_r = random.log_uniform(1, 50) * I;
    const Pushed pushed{.body = rigid_body(m, Vec3(I, 1.3 * I, 1.7 * I).asDiagonal()),
                        .coupling = {.k = k,
                                     .g = random.uniform(0.2, 2) * std::sqrt(m * k),
                                     .k_r = k_r,
                                     .g_r = random.uniform(0.2, 2) * std::sqrt(I * k_r)},
                        .f = m * random.uniform(0.1, 5) * random.direction(),
                        .tau = I * random.uniform(0.1, 5) * random.direction(),
                        .frequency = random.log_uniform(0.3, 5),
                        .phase = random.uniform(-pi, pi)};
    const Real of_free = order_of<TrBdf2, None>(pushed, 1000),
               of_held = order_of<TrBdf2, DampedSpring>(pushed, 1000);
    EXPECT_GT(of_free, 1.9) << draw;
    EXPECT_GT(of_held, 1.9) << draw;
    lowest = std::min({lowest, of_free, of_held});
    highest = std::max({highest, of_free, of_held});
  }
  std::cout << "order " << lowest << " to " << highest << '\n';
}

/// The momentum that the hand gives is the mean of its forces at the ends of each step.
TEST(AdmittanceWithTrBdf2, MomentumIsThatOfTheHand) {
  const Pushed pushed{.body = rigid_body(0.3, Vec3(1e-3, 1e-3, 1e-3).asDiagonal()),
                      .coupling = {},
                      .f = Vec3(0.5, 0, 0),
                      .tau = Vec3::Zero(),
                      .frequency = 1,
                      .phase = 0};
  constexpr Real seconds = 0.25;
  const RigidBodyState end = pushed.after<TrBdf2, None>(seconds, 1000);
  EXPECT_NEAR(0.3 * end.v_W.x(), 0.5 / (2 * pi), 2e-7);
}

}  // namespace
}  // namespace godobject::test_admittance_order
