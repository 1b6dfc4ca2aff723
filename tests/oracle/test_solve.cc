#include "tests/oracle/solve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/oracle/compare.h"
#include "tests/oracle/dynamics.h"
#include "tests/oracle/energy.h"
#include "tests/oracle/scenes.h"
#include "tests/oracle/target.h"

namespace godobject::oracle::test_solve {
namespace {

Vector3d rotated_by(const Quaterniond& q) { return rotation_vector(q.cast<Scalar>()).cast<double>(); }

Quaterniond turn(const Vector3d& axis, double angle) { return Quaterniond(Eigen::AngleAxisd(angle, axis)); }

Body free_body() {
  Body body;
  body.m = 0.3;
  body.I_B << 0.020, 0.004, -0.003, 0.004, 0.050, 0.006, -0.003, 0.006, 0.060;
  body.start.q = turn(Vector3d(1, 2, -1).normalized(), 0.7);
  body.start.v = {0.1, -0.2, 0.3};
  body.start.w = {0.5, 12, 1};
  return body;
}

/// Response of x'' + 2 a x' + b x = 0 to x = 1, x' = 0, underdamped.
double underdamped(double a, double b, double t) {
  const double omega = std::sqrt(b - a * a);
  return std::exp(-a * t) * (std::cos(omega * t) + a / omega * std::sin(omega * t));
}

TEST(RotationVector, InvertsTheExponentialAtEveryAngle) {
  const Vector3d u = Vector3d(2, -1, 3).normalized();
  for (const double alpha : {0.0, 1e-9, 1e-5, 1.9e-4, 2.1e-4, 0.5, 3.0, std::numbers::pi - 1e-6}) {
    const Vector3d expected = alpha * u;
    EXPECT_LT((rotated_by(turn(u, alpha)) - expected).norm(), 1e-15 * (1 + alpha)) << alpha;
  }
  EXPECT_LT((rotated_by(turn(u, 4)) - (4 - 2 * std::numbers::pi) * u).norm(), 1e-14);  // the short way
}

TEST(Solve, FreeFallIsAParabola) {
  Case problem{.gravity = {0, 0, -9.81}, .bodies = {free_body()}};
  const double t = 1.7;
  const RigidState x = solve(problem, std::vector{t}).states[0][0];
  const Vector3d expected = problem.bodies[0].start.v * t + 0.5 * t * t * problem.gravity;
  EXPECT_LT((x.p - expected).norm(), 1e-12);
}

TEST(Solve, StepResponseIsThatOfTwoDampedOscillators) {
  // A sphere turns about the axis of the step alone, so its angle obeys the scalar equation exactly.
  const double angle = 2.5;
  const Vector3d axis = Vector3d(1, -2, 2) / 3, shift(0.05, -0.03, 0.02);
  RigidState rest;
  rest.p = shift;
  rest.q = turn(axis, angle);
  Body body;
  body.m = 0.1;
  body.I_B *= 1e-4;
  body.coupling = Coupling{.k_t = 1000,
                           .g_t = 14,
                           .k_r = 1,
                           .g_r = 0.014,
                           .target = std::make_shared<FunctionTarget>([rest](double) { return rest; })};
  for (const double t : {0.003, 0.02, 0.1}) {
    const RigidState x = solve({.bodies = {body}}, std::vector{t}).states[0][0];
    const Vector3d p = shift * (1 - underdamped(70, 1e4, t));
    const Quaterniond q = turn(axis, angle * (1 - underdamped(70, 1e4, t)));
    EXPECT_LT((x.p - p).norm(), 1e-12);
    EXPECT_LT(x.q.angularDistance(q), 1e-11);
  }
}

TEST(Solve, ToolStaysOnATargetInUniformMotion) {
  // Damping acts on the velocity relative to the target: no lag in translation, none about a fixed axis.
  const Vector3d v(0.2, -0.1, 0.3), w(3, 4, 12);
  const auto motion = [v, w](double t) {
    return RigidState{.p = v * t, .q = turn(w.normalized(), w.norm() * t), .v = v, .w = w};
  };
  Body body;
  body.m = 0.1;
  body.I_B *= 1e-4;
  body.start = motion(0);
  body.coupling = Coupling{
      .k_t = 1000, .g_t = 14, .k_r = 1, .g_r = 0.014, .target = std::make_shared<FunctionTarget>(motion)};
  const WorstDifference worst =
      worst_difference(solve({.bodies = {body}}, std::vector{2.0}).states[0][0], motion(2));
  EXPECT_LT(worst.p, 1e-12);
  EXPECT_LT(worst.q, 1e-12);
  EXPECT_LT(worst.v, 1e-11);
  EXPECT_LT(worst.w, 1e-11);
}

TEST(Solve, TorqueFreeBodyKeepsEnergyAndMomentum) {
  const Body body = free_body();
  const double energy = kinetic_energy(body, body.start);
  const Vector3d momentum = angular_momentum(body, body.start);
  double worst_energy = 0, worst_momentum = 0;
  for (const auto& states : solve({.bodies = {body}}, uniform_times(4, 0.02)).states) {
    worst_energy = larger(std::abs(kinetic_energy(body, states[0]) / energy - 1), worst_energy);
    worst_momentum =
        larger((angular_momentum(body, states[0]) - momentum).norm() / momentum.norm(), worst_momentum);
  }
  std::printf(
      "torque-free, full inertia tensor, 4 s: relative error of energy %.1e, of angular momentum %.1e\n",
      worst_energy, worst_momentum);
  EXPECT_LT(worst_energy, 1e-10);
  EXPECT_LT(worst_momentum, 1e-10);
}

TEST(Solve, TumblingMeetsQuadruplePrecision) {
  // Expected: Euler's equations by classic RK4 with a 113-bit mantissa; steps of 10 us and 40 us agree to
  // 1e-13. The intermediate axis makes it a hard case: in 4 s any error grows a million times.
  Body body;
  body.I_B = Vector3d(0.02, 0.05, 0.08).asDiagonal();
  body.start.w = {0.01, 12, 0.02};
  RigidState expected;
  expected.q = Quaterniond(-0.393947902351698, 0.445377199387742, -0.738468819895074, -0.31797484576772);
  expected.w = {1.06282203603881, 11.9778141019742, 8.20810900516091};
  const WorstDifference worst =
      worst_difference(solve({.bodies = {body}}, std::vector{4.0}, 1e-16).states[0][0], expected);
  std::printf("tumbling, 4 s, against quadruple precision: q %.1e, w %.1e rad/s\n", worst.q, worst.w);
  EXPECT_LT(worst.q, 1e-11);
  EXPECT_LT(worst.w, 1e-10);
}

TEST(Solve, FullInertiaTensorIsThePrincipalOneSeenFromTurnedAxes) {
  Case principal = scene_s1();
  Case turned = principal;
  const Quaterniond q_BP = turn(Vector3d(1, 1, -2).normalized(), 1.1);
  const Matrix3d R_BP = q_BP.toRotationMatrix();
  Body& body = turned.bodies[0];
  body.I_B = R_BP * body.I_B * R_BP.transpose();
  body.I_B = 0.5 * (body.I_B + body.I_B.transpose()).eval();
  body.start.q = body.start.q * q_BP.conjugate();
  body.coupling->target = std::make_shared<FunctionTarget>([q_BP](double t) {
    RigidState D = scene_s1_target(t);
    D.q = D.q * q_BP.conjugate();
    return D;
  });
  const std::vector<double> times = uniform_times(2, 0.1);
  Solution seen = solve(turned, times);
  for (auto& states : seen.states) states[0].q = states[0].q * q_BP;
  const WorstDifference worst = worst_difference(seen, solve(principal, times));
  EXPECT_LT(worst.p, 1e-11);
  EXPECT_LT(worst.q, 1e-11);
  EXPECT_LT(worst.v, 1e-11);
  EXPECT_LT(worst.w, 1e-11);
}

TEST(Solve, SceneS1DoesNotDependOnTheTolerance) {
  const std::vector<double> times = uniform_times(20, 0.1);
  const WorstDifference worst =
      worst_difference(solve(scene_s1(), times, 1e-11), solve(scene_s1(), times, 1e-13));
  std::printf("S1, 20 s, tolerance 1e-11 against 1e-13: p %.1e m, q %.1e, v %.1e m/s, w %.1e rad/s\n",
              worst.p, worst.q, worst.v, worst.w);
  EXPECT_LT(worst.p, 1e-10);
  EXPECT_LT(worst.q, 1e-10);
  EXPECT_LT(worst.v, 1e-10);
  EXPECT_LT(worst.w, 1e-10);
}

TEST(Solve, StepsEndAtTheKnotsOfATarget) {
  // After a long rest the target leaves and returns within 1 ms, which a long step would jump over.
  const double start = 1.5, duration = 1e-3, height = 1e-3;
  const auto bump = [=](double t) {
    const double s = std::clamp((t - start) / duration, 0.0, 1.0);
    RigidState D;
    D.p.x() = 16 * height * s * s * (1 - s) * (1 - s);
    D.v.x() = 32 * height / duration * s * (1 - s) * (1 - 2 * s);
    return D;
  };
  Body body;
  body.m = 0.1;
  body.coupling = Coupling{.k_t = 1000, .g_t = 14};
  body.coupling->target = std::make_shared<FunctionTarget>(bump, std::vector{start, start + duration});
  const RigidState x = solve({.bodies = {body}}, std::vector{1.52}).states[0][0];
  const std::vector<double> dense = uniform_times(1.52, 1e-4);
  const RigidState expected = solve({.bodies = {body}}, dense).states.back()[0];
  EXPECT_GT(expected.p.x(), 1e-6);
  EXPECT_LT(worst_difference(x, expected).p, 1e-12);
}

TEST(Solve, BodiesDoNotDisturbEachOther) {
  Case both = scene_s1();
  both.bodies.push_back(free_body());
  const std::vector<double> times = {0, 0.5, 0.5, 1};  // the start, and a repeated time
  const Solution solution = solve(both, times);
  ASSERT_EQ(solution.times, times);
  EXPECT_EQ(solution.states[0][1].w, free_body().start.w);
  EXPECT_EQ(solution.states[1][0].p, solution.states[2][0].p);
  for (std::size_t i = 0; i < 2; ++i) {
    const Solution alone = solve({.bodies = {both.bodies[i]}}, times);
    EXPECT_LT(worst_difference(alone.states[3][0], solution.states[3][i]).w, 1e-10);
  }
}

TEST(Solve, RefusesACaseThatBreaksItsRules) {
  const std::vector<double> times = {1.0};
  Case problem{.bodies = {free_body()}};
  problem.bodies[0].m = 0;
  EXPECT_THROW(solve(problem, times), std::invalid_argument);
  problem.bodies[0] = free_body();
  problem.bodies[0].I_B(2, 2) = -1;
  EXPECT_THROW(solve(problem, times), std::invalid_argument);
  problem.bodies[0] = free_body();
  problem.bodies[0].coupling = Coupling{};
  EXPECT_THROW(solve(problem, times), std::invalid_argument);
  problem.bodies[0] = free_body();
  EXPECT_THROW(solve(problem, std::vector{1.0, 0.5}), std::invalid_argument);
  EXPECT_THROW(solve(problem, times, 0), std::invalid_argument);
}

}  // namespace
}  // namespace godobject::oracle::test_solve
