// Observed order of the integrators on a smooth motion, and conserved quantities of a free body.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/core/one_body.h"

namespace godobject::test_convergence {
namespace {

/// A smooth motion of all six degrees of freedom with its exact velocity: turns about z, then about x.
Target motion(Real t) {
  const Real a = 0.8 * std::sin(5 * t), a_dot = 4 * std::cos(5 * t);
  const Real b = 0.6 * std::sin(7 * t + 0.4), b_dot = 4.2 * std::cos(7 * t + 0.4);
  const Quat q_a(std::cos(a / 2), 0, 0, std::sin(a / 2)), q_b(std::cos(b / 2), std::sin(b / 2), 0, 0);
  return {.X_WD = {.p = 0.1 * Vec3(std::sin(6 * t), std::cos(4 * t), std::sin(9 * t)), .q = q_a * q_b},
          .V_WD = {.w = a_dot * Vec3::UnitZ() + b_dot * (q_a * Vec3::UnitX()),
                   .v = 0.1 * Vec3(6 * std::cos(6 * t), -4 * std::sin(4 * t), 9 * std::cos(9 * t))}};
}

Mat3 full_inertia() {
  Mat3 I_B;
  I_B << 5e-3, 1e-3, -5e-4, 1e-3, 3e-3, 4e-4, -5e-4, 4e-4, 6e-3;
  return I_B;
}

/// The state at the end of 0.8 s in `steps` steps, under gravity, starting off the target.
template <class Integrator>
RigidBodyState follow(int steps) {
  constexpr Real duration = 0.8;
  Running<OneBody<Integrator>> run;
  run.par.h = duration / steps;
  run.par.gravity_W = Vec3(0, 1, -9.81);
  run.constants().body = rigid_body(0.2, full_inertia());
  run.constants().coupling = {.k = 500, .g = 15, .k_r = 5, .g_r = 0.25};
  const Target first = motion(0);
  place(run.x, 0,
        {.X_WB = {.p = first.X_WD.p + Vec3(0.02, 0, 0.01), .q = first.X_WD.q},
         .V_WB = {.w = Vec3(3, -2, 8), .v = Vec3::Zero()}});
  engage_at(run.x, 0, first);
  for (int n = 1; n <= steps; ++n) {
    const Target sample = motion(duration * n / steps);
    run.device().target = sample;
    run.step();
  }
  EXPECT_FALSE(any(run.out.fault));
  return run.body();
}

/// Returns the same body thrown into the air: gravity, gyroscopic torque, no spring.
template <class Integrator>
RigidBodyState tumble(int steps) {
  constexpr Real duration = 0.8;
  Running<OneBody<Integrator, None, None>> run;
  run.par.h = duration / steps;
  run.par.gravity_W = Vec3(0, 1, -9.81);
  run.constants().body = rigid_body(0.2, full_inertia());
  place(run.x, 0, {.X_WB = {}, .V_WB = {.w = Vec3(3, 12, 1), .v = Vec3(1, 2, 3)}});
  run.step(steps);
  return run.body();
}

struct Difference {
  Real position, angle, velocity, angular_velocity;
};

Difference difference(const RigidBodyState& a, const RigidBodyState& b) {
  return {.position = (a.X_WB.p - b.X_WB.p).norm(),
          .angle = a.X_WB.q.angularDistance(b.X_WB.q),
          .velocity = (a.v_W - b.v_W).norm(),
          .angular_velocity = (a.w_B - b.w_B).norm()};
}

/// Between 2 ms and 0.25 ms, per halving, against the same scheme with a step 64 times smaller.
template <class Solve>
Difference observed_order(Solve solve) {
  const RigidBodyState exact = solve(204800);
  const Difference coarse = difference(solve(400), exact), fine = difference(solve(3200), exact);
  const auto order = [](Real e_coarse, Real e_fine) { return std::log2(e_coarse / e_fine) / 3; };
  const Difference p{.position = order(coarse.position, fine.position),
                     .angle = order(coarse.angle, fine.angle),
                     .velocity = order(coarse.velocity, fine.velocity),
                     .angular_velocity = order(coarse.angular_velocity, fine.angular_velocity)};
  std::cout << "errors at 0.25 ms: " << fine.position << " m, " << fine.angle << " rad; orders " << p.position
            << ", " << p.angle << "\n";
  return p;
}

template <class Integrator>
class Convergence : public ::testing::Test {
 protected:
  static constexpr Real least_order = Integrator::order - 0.1;
};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Convergence, Integrators);

TYPED_TEST(Convergence, FollowingASmoothMotion) {
  const Difference p = observed_order(follow<TypeParam>);
  EXPECT_GE(p.position, this->least_order);
  EXPECT_GE(p.angle, this->least_order);
  EXPECT_GE(p.velocity, this->least_order);
  EXPECT_GE(p.angular_velocity, this->least_order);
}

TYPED_TEST(Convergence, FallingAndTumbling) {
  const Difference p = observed_order(tumble<TypeParam>);
  EXPECT_GE(p.angle, this->least_order);
  EXPECT_GE(p.angular_velocity, this->least_order);
}

TYPED_TEST(Convergence, BothSchemesAgreeInTheLimit) {
  const Difference d = difference(follow<TypeParam>(204800), follow<TrBdf2>(12800));
  EXPECT_LT(d.position, 1e-5);
  EXPECT_LT(d.angle, 1e-4);
}

TEST(ConvergenceOfFreeFall, TrBdf2IsExact) {
  const RigidBodyState x = tumble<TrBdf2>(800);
  const Vec3 a_W(0, 1, -9.81);
  // The first step has no acceleration and is two implicit Euler steps: v is exact, p off by O(h^2).
  EXPECT_LT((x.v_W - (Vec3(1, 2, 3) + 0.8 * a_W)).norm(), 1e-12);
  EXPECT_LT((x.X_WB.p - (0.8 * Vec3(1, 2, 3) + 0.32 * a_W)).norm(), 1e-5);
}

/// Intermediate-axis tumbling, the numbers of the torque-free reference case; with a full tensor too.
TEST(ConvergenceOfTorqueFree, TrBdf2KeepsEnergyAndAngularMomentum) {
  const Mat3 diagonal = Vec3(0.02, 0.05, 0.08).asDiagonal();
  const Mat3 R = Random(1).rotation().toRotationMatrix();
  for (const Mat3& axes : {Mat3(Mat3::Identity()), R}) {
    Running<OneBody<TrBdf2, None, None>> run;
    const Mat3 I_B = axes * diagonal * axes.transpose();
    run.constants().body = rigid_body(1, Real(0.5) * (I_B + I_B.transpose()));
    place(run.x, 0, {.X_WB = {}, .V_WB = {.w = axes * Vec3(0.01, 12, 0.02), .v = Vec3(0.1, -0.2, 0.3)}});
    const Real energy = run.kinetic();
    const Vec3 L_W = to_world(run.body().X_WB.q, I_B * run.body().w_B);
    Real energy_error = 0, momentum_error = 0;
    for (int n = 0; n < 4000; ++n) {
      run.step();
      energy_error = std::max(energy_error, std::abs(run.kinetic() / energy - 1));
      const Vec3 L_now_W = to_world(run.body().X_WB.q, I_B * run.body().w_B);
      momentum_error = std::max(momentum_error, (L_now_W - L_W).norm() / L_W.norm());
    }
    std::cout << "energy within " << energy_error << ", angular momentum within " << momentum_error << "\n";
    EXPECT_LT(energy_error, 1e-3);
    EXPECT_LT(momentum_error, 1e-3);
    EXPECT_LT((run.body().X_WB.p - 4 * Vec3(0.1, -0.2, 0.3)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace godobject::test_convergence
