// Joints against closed forms: motions, reactions, and the work of prescribed motions.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/oracle/compare.h"
#include "tests/oracle/energy.h"
#include "tests/oracle/solve.h"

namespace godobject::oracle::test_joint_reactions {
namespace {

constexpr double g = 9.81;

Quaterniond turn(const Vector3d& axis, double angle) { return Quaterniond(Eigen::AngleAxisd(angle, axis)); }

/// A slender rod along z of its body frame.
Body rod(double m, double length) {
  Body body;
  body.name = "rod";
  body.m = m;
  body.I_B = (m * length * length / 12 * Vector3d(1, 1, 0.01)).asDiagonal();
  return body;
}

TEST(JointReaction, CantileverOfTwoBodiesCarriesItsWeight) {
  Case problem{.gravity = {0, 0, -g}, .bodies = {rod(2, 1), rod(0.5, 1)}};
  problem.bodies[0].start.p = {0.4, 0.1, 0};
  problem.bodies[1].start.p = {1.0, 0.3, 0.2};
  const Vector3d wall(-0.1, 0, 0.05), seam(0.7, 0.2, 0.1);
  problem.joints = {{.name = "wall",
                     .type = JointType::fixed,
                     .child = 0,
                     .anchor_P = wall,
                     .anchor_C = wall - problem.bodies[0].start.p},
                    {.name = "seam",
                     .type = JointType::fixed,
                     .parent = 0,
                     .child = 1,
                     .anchor_P = seam - problem.bodies[0].start.p,
                     .anchor_C = seam - problem.bodies[1].start.p}};
  const Solution solution = solve(problem, std::vector{0.0, 0.5});
  const Vector3d weight0 = 2 * problem.gravity, weight1 = 0.5 * problem.gravity;
  const Vector3d p0 = problem.bodies[0].start.p, p1 = problem.bodies[1].start.p;
  for (const std::vector<JointWrench>& reactions : solution.reactions) {
    EXPECT_LT((reactions[0].f + weight0 + weight1).norm(), 1e-13);
    EXPECT_LT((reactions[0].tau + (p0 - wall).cross(weight0) + (p1 - wall).cross(weight1)).norm(), 1e-13);
    EXPECT_LT((reactions[1].f + weight1).norm(), 1e-13);
    EXPECT_LT((reactions[1].tau + (p1 - seam).cross(weight1)).norm(), 1e-13);
  }
  EXPECT_LT((solution.states[1][1].p - p1).norm(), 1e-15);
}

/// A rod on a hinge along y at the origin, the rod's upper end there; angle zero hangs down.
Case pendulum(double m, double length) {
  return {.gravity = {0, 0, -g},
          .bodies = {rod(m, length)},
          .joints = {{.name = "pivot",
                      .type = JointType::hinge,
                      .child = 0,
                      .anchor_C = {0, 0, length / 2},
                      .axis_P = Vector3d::UnitY()}}};
}

TEST(JointReaction, HangingPendulumPullsOnItsHingeWithItsWeight) {
  Case problem = pendulum(0.3, 0.4);
  problem.joints[0].anchor_C.y() = 0.05;  // the centre of mass is not below the anchor
  problem.bodies[0].start.p = {0, -0.05, -0.2};
  const JointWrench reaction = solve(problem, std::vector{1.0}).reactions[0][0];
  EXPECT_LT((reaction.f - Vector3d(0, 0, 0.3 * g)).norm(), 1e-14);
  EXPECT_LT((reaction.tau - Vector3d(0, -0.05, -0.2).cross(Vector3d(0, 0, 0.3 * g))).norm(), 1e-14);
}

TEST(JointReaction, RodReleasedFromTheHorizontal) {
  // About the pivot I = m L^2 / 3, so w^2 = 3 g sin(fall) / L and w' = 3/2 g cos(fall) / L; the reaction is
  // m g cos(fall) / 4 across the rod and 5/2 m g sin(fall) along it.
  const double m = 0.3, length = 0.4;
  Case problem = pendulum(m, length);
  problem.bodies[0].I_B = (m * length * length / 12 * Vector3d(1, 1, 0.01)).asDiagonal();
  problem.bodies[0].start.q = turn(Vector3d::UnitY(), -std::numbers::pi / 2);
  problem.bodies[0].start.p = {length / 2, 0, 0};
  const Solution solution = solve(problem, uniform_times(1, 0.01));
  double deepest = 0;
  for (std::size_t i = 0; i < solution.times.size(); ++i) {
    const RigidState& x = solution.states[i][0];
    const Vector3d out = -(x.q * Vector3d::UnitZ()), across = x.q * Vector3d::UnitX();
    const double sin_fall = -out.z();
    deepest = std::max(sin_fall, deepest);
    EXPECT_NEAR(x.w.y() * x.w.y(), 3 * g * sin_fall / length, 1e-11);
    const Vector3d expected = -2.5 * m * g * sin_fall * out + 0.25 * m * g * across.z() * across;
    EXPECT_LT((solution.reactions[i][0].f - expected).norm(), 1e-12) << "t = " << solution.times[i];
  }
  EXPECT_GT(deepest, 0.99);  // it passed the lowest point
}

TEST(JointReaction, ConicalPendulum) {
  // Steady precession w = W z at angle beta: W^2 (I_t + m l^2 - I_a) cos(beta) = m g l.
  const double m = 0.3, length = 0.4, l = length / 2, beta = 0.6;
  Case problem = pendulum(m, length);
  problem.joints[0].type = JointType::ball;
  Body& body = problem.bodies[0];
  const double W = std::sqrt(m * g * l / ((body.I_B(0, 0) + m * l * l - body.I_B(2, 2)) * std::cos(beta)));
  const auto exact = [=](double t) {
    RigidState x;
    x.w = {0, 0, W};
    x.q = turn(Vector3d::UnitZ(), W * t) * turn(Vector3d::UnitY(), -beta);
    x.p = x.q * Vector3d(0, 0, -l);
    x.v = x.w.cross(x.p);
    return x;
  };
  body.start = exact(0);
  const Solution solution = solve(problem, uniform_times(5, 0.1));
  for (std::size_t i = 0; i < solution.times.size(); ++i) {
    const RigidState x = exact(solution.times[i]);
    const WorstDifference worst = worst_difference(solution.states[i][0], x);
    EXPECT_LT(worst.p, 1e-11);
    EXPECT_LT(worst.q, 1e-11);
    EXPECT_LT(worst.w, 1e-10);
    const Vector3d inward(-x.p.x(), -x.p.y(), 0);
    const Vector3d expected = m * W * W * inward + Vector3d(0, 0, m * g);
    EXPECT_LT((solution.reactions[i][0].f - expected).norm(), 1e-10);
  }
}

TEST(JointReaction, HeavyTopMeetsQuadruplePrecision) {
  // The benchmark of Lie-group integrators at 2 s. Expected: Euler's equations about the fixed point, in body
  // axes and without a joint, by classic RK4 with a 113-bit mantissa. Steps of 2.5 us and 1.25 us agree to
  // 1e-14.
  Case problem{.gravity = {0, 0, -g}, .bodies = {rod(15, 1)}};
  Body& top = problem.bodies[0];
  top.I_B = Vector3d(0.234375, 0.46875, 0.234375).asDiagonal();
  top.start.p = {0, 1, 0};
  top.start.v = {4.61538, 0, 0};
  top.start.w = {0, 150, -4.61538};
  problem.joints = {{.name = "tip", .type = JointType::ball, .child = 0, .anchor_C = {0, -1, 0}}};
  RigidState expected;
  expected.p = {-0.150416822745642, -0.724165591636895, -0.673022269560445};
  expected.q = Quaterniond(0.122947135041533, -0.491079892550027, 0.350430030343622, -0.787986887550485);
  expected.w = {-27.6585155258234, -106.163804143124, -102.462463805326};
  expected.v = expected.w.cross(expected.p);
  const WorstDifference worst =
      worst_difference(solve(problem, std::vector{2.0}, 1e-16).states[0][0], expected);
  std::printf("heavy top, 2 s, against quadruple precision: p %.1e m, q %.1e, v %.1e m/s, w %.1e rad/s\n",
              worst.p, worst.q, worst.v, worst.w);
  EXPECT_LT(worst.p, 1e-13);
  EXPECT_LT(worst.q, 1e-13);
  EXPECT_LT(worst.v, 1e-11);
  EXPECT_LT(worst.w, 1e-11);
}

TEST(JointReaction, BlockOnAnInclineSlidesAndPressesOnIt) {
  const double m = 0.3, alpha = 0.4, t = 0.8;
  const Vector3d down(std::cos(alpha), 0, -std::sin(alpha)), normal(std::sin(alpha), 0, std::cos(alpha));
  Case problem{.gravity = {0, 0, -g}, .bodies = {rod(m, 0.2)}};
  problem.joints = {{.name = "rail", .type = JointType::slider, .child = 0, .axis_P = down}};
  const Solution solution = solve(problem, std::vector{t});
  const RigidState& x = solution.states[0][0];
  EXPECT_LT((x.p - 0.5 * g * std::sin(alpha) * t * t * down).norm(), 1e-13);
  EXPECT_LT((solution.reactions[0][0].f - m * g * std::cos(alpha) * normal).norm(), 1e-14);
}

JointCoordinate swing(double t) {
  return {0.7 * std::sin(3 * t), 2.1 * std::cos(3 * t), -6.3 * std::sin(3 * t)};
}

TEST(ImposedJoint, HingeDrivesThePendulum) {
  const double m = 0.3, length = 0.4, l = length / 2;
  Case problem = pendulum(m, length);
  problem.joints[0].imposed = ImposedMotion{.at = swing};
  Body& body = problem.bodies[0];
  body.start.p = {0, 0, -l};
  body.start.w = {0, swing(0).d1, 0};
  body.start.v = body.start.w.cross(body.start.p);
  const Solution solution = solve(problem, uniform_times(2, 0.1));
  for (std::size_t i = 0; i < solution.times.size(); ++i) {
    const JointCoordinate x = swing(solution.times[i]);
    EXPECT_LT(solution.states[i][0].q.angularDistance(turn(Vector3d::UnitY(), x.value)), 1e-14);
    EXPECT_NEAR(solution.states[i][0].w.y(), x.d1, 1e-14);
    const double torque = (body.I_B(1, 1) + m * l * l) * x.d2 + m * g * l * std::sin(x.value);
    EXPECT_NEAR(solution.reactions[i][0].tau.y(), torque, 1e-13);
  }
}

TEST(ImposedJoint, SliderLiftsABlock) {
  const double m = 0.3;
  Case problem{.gravity = {0, 0, -g}, .bodies = {rod(m, 0.2)}};
  problem.joints = {
      {.name = "lift", .type = JointType::slider, .child = 0, .imposed = ImposedMotion{.at = swing}}};
  problem.bodies[0].start.v = {0, 0, swing(0).d1};
  const Solution solution = solve(problem, uniform_times(2, 0.1));
  for (std::size_t i = 0; i < solution.times.size(); ++i) {
    const JointCoordinate x = swing(solution.times[i]);
    EXPECT_NEAR(solution.states[i][0].p.z(), x.value, 1e-14);
    EXPECT_NEAR(solution.reactions[i][0].f.z(), m * (x.d2 + g), 1e-13);
  }
}

/// Integral of equidistant samples, of odd number, by Simpson's rule.
double integral(const std::vector<double>& samples, double step) {
  double sum = samples.front() + samples.back();
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) sum += (i % 2 == 1 ? 4 : 2) * samples[i];
  return sum * step / 3;
}

TEST(ImposedJoint, WorkBetweenFloatingBodiesIsTheirEnergy) {
  // The parent turns and shifts freely: every velocity product of the moving frame takes part.
  for (const JointType type : {JointType::hinge, JointType::slider}) {
    Case problem{.bodies = {rod(0.5, 0.6), rod(0.3, 0.4)}};
    Body &P = problem.bodies[0], &C = problem.bodies[1];
    Joint joint{.name = "drive", .type = type, .parent = 0, .child = 1, .axis_P = Vector3d(2, -1, 2) / 3};
    joint.anchor_P = {0.05, 0, 0.3};
    joint.anchor_C = {0, 0.02, -0.2};
    joint.imposed = ImposedMotion{.at = swing};
    P.start.w = {1, 2, 0.5};
    const Vector3d drive = swing(0).d1 * joint.axis_P;
    C.start.p = joint.anchor_P - joint.anchor_C;
    C.start.w = type == JointType::hinge ? Vector3d(P.start.w + drive) : P.start.w;
    C.start.v = P.start.w.cross(joint.anchor_P) - C.start.w.cross(joint.anchor_C);
    if (type == JointType::slider) C.start.v += drive;
    problem.joints = {joint};

    const double step = 1e-3;
    const Solution solution = solve(problem, uniform_times(1, step));
    std::vector<double> power;
    for (std::size_t i = 0; i < solution.times.size(); ++i) {
      const JointWrench& on_child = solution.reactions[i][0];
      const Vector3d axis = solution.states[i][0].q * joint.axis_P;
      const Vector3d effort = type == JointType::hinge ? on_child.tau : on_child.f;
      power.push_back(effort.dot(axis) * swing(solution.times[i]).d1);
    }
    const std::vector<RigidState>&start = solution.states.front(), &end = solution.states.back();
    const double gained = energy(problem, end) - energy(problem, start);
    std::printf("imposed %s between floating bodies: energy gained %.6f J, work less that %.1e J\n",
                type == JointType::hinge ? "hinge" : "slider", gained, integral(power, step) - gained);
    EXPECT_GT(std::abs(gained), 1e-3);
    EXPECT_NEAR(integral(power, step), gained, 1e-11);
    EXPECT_LT((momentum(problem, end) - momentum(problem, start)).norm(), 1e-13);
    EXPECT_LT((angular_momentum(problem, end) - angular_momentum(problem, start)).norm(), 1e-13);
  }
}

TEST(ImposedJoint, StepsEndAtItsKnots) {
  // A lift that only moves within 2 ms after a long rest.
  const auto bump = [](double t) {
    const double s = (t - 0.5) / 2e-3;
    if (s <= 0) return JointCoordinate{};
    if (s >= 1) return JointCoordinate{1e-3, 0, 0};
    const double rate = 1 / 2e-3;
    return JointCoordinate{1e-3 * s * s * s * (10 + s * (-15 + 6 * s)),
                           1e-3 * rate * 30 * s * s * (1 - s) * (1 - s),
                           1e-3 * rate * rate * 60 * s * (1 - s) * (1 - 2 * s)};
  };
  Case problem{.bodies = {rod(0.3, 0.2), rod(0.3, 0.2)}};
  problem.joints = {
      {.name = "lift",
       .type = JointType::slider,
       .child = 0,
       .imposed = ImposedMotion{.at = bump, .knots = {0.5, 0.502}}},
      {.name = "rail", .type = JointType::slider, .parent = 0, .child = 1, .axis_P = Vector3d(0.6, 0, 0.8)}};
  // The passenger slides on a rail at angle: its velocity across is constant, s' = -cos(angle) of the lift's.
  const Solution solution = solve(problem, std::vector{0.6});
  EXPECT_NEAR(solution.states[0][0].p.z(), 1e-3, 1e-14);
  EXPECT_NEAR(solution.states[0][1].p.x(), -0.48e-3, 1e-12);
  EXPECT_NEAR(solution.states[0][1].p.z(), 1e-3 - 0.64e-3, 1e-12);
}

}  // namespace
}  // namespace godobject::oracle::test_joint_reactions
