// Motions: accuracy of the cubic, exact twists, behaviour on recorded data, and refusal of bad tables.
#include "platform/motion/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <random>
#include <utility>

#include "platform/scene/text/key.h"

namespace godobject::test_motion {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

SceneConfig one_coupled_body() {
  SceneConfig scene;
  scene.bodies.push_back({.name = "tool",
                          .X_WB = {Vec3(1, 2, 3), Quat::Identity()},
                          .V_WB = {},
                          .coupling = SpringParams{},
                          .feedback = {}});
  return scene;
}

MotionConfig six_dof() {
  MotionConfig m;
  m.amplitude = Vec3(0.1, 0.08, 0.06);
  m.frequency_hz = Vec3(0.5, 0.7, 1.1);
  m.phase = Vec3(0, 0.5, 1.1);
  m.angle_amplitude = Vec3(1.0, 0.6, 0.8);
  m.angle_frequency_hz = Vec3(0.4, 0.9, 0.6);
  m.angle_phase = Vec3(0.7, 0.3, 0);
  m.X_WD = {Vec3(0.1, 0.2, 0.3), Quat(0.5, 0.5, -0.5, 0.5)};
  return m;
}

Motion built_in() {
  SceneConfig scene = one_coupled_body();
  scene.motion = six_dof();
  return Motion(scene);
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat d = a.conjugate() * b;
  return 2 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

/// Returns angular velocity and velocity by a symmetric difference over +-e.
Twist difference_twist(const Motion& motion, double t, double e) {
  const Pose before = motion.target(0, t - e).X_WD, after = motion.target(0, t + e).X_WD;
  const Eigen::AngleAxis<Real> turn(Eigen::Quaternion<Real>(after.q * before.q.conjugate()));
  const double angle = turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
  return {turn.axis() * angle / (2 * e), (after.p - before.p) / (2 * e)};
}

std::string row(double t, const Pose& X) {
  std::string text = shortest(t);
  for (const double x : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()})
    text.append(",").append(shortest(x));
  return text + "\n";
}

const std::string pose_header = "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n";

/// Samples the built-in motion at h for 2 s. jitter: largest shift of a time, as a share of h. Every third
/// quaternion has the other sign.
Motion sampled(double h, double jitter) {
  const Motion exact = built_in();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-jitter, jitter);
  std::string csv = pose_header;
  const int n = static_cast<int>(std::lround(2 / h));
  for (int i = 0; i <= n; ++i) {
    const double t = h * (i + (i == 0 || i == n ? 0 : uniform(random)));
    Pose X = exact.target(0, t).X_WD;
    if (i % 3 == 1) X.q.coeffs() *= -1;
    csv += row(t, X);
  }
  const MotionResult result = Motion::parse(csv, "m.csv", one_coupled_body());
  EXPECT_THAT(result.errors, IsEmpty());
  return *result.motion;
}

struct WorstErrors {
  double p = 0, q = 0, v = 0, w = 0;
};

WorstErrors compare(const Motion& motion, const Motion& exact, double end) {
  WorstErrors worst;
  for (double t = 0; t <= end; t += 0.77e-3) {
    const Target a = motion.target(0, t), b = exact.target(0, t);
    worst.p = std::max(worst.p, (a.X_WD.p - b.X_WD.p).norm());
    worst.q = std::max(worst.q, angle_between(a.X_WD.q, b.X_WD.q));
    worst.v = std::max(worst.v, (a.V_WD.v - b.V_WD.v).norm());
    worst.w = std::max(worst.w, (a.V_WD.w - b.V_WD.w).norm());
  }
  return worst;
}

TEST(Motion, BuiltInTwistIsTheDerivativeOfItsPose) {
  const Motion motion = built_in();
  for (double t = 0.01; t < 3; t += 0.0937) {
    const Twist V = motion.target(0, t).V_WD, D = difference_twist(motion, t, 1e-4);
    EXPECT_LT((V.v - D.v).norm(), 1e-6) << t;
    EXPECT_LT((V.w - D.w).norm(), 1e-6) << t;
  }
}

TEST(Motion, WithoutMotionTheTargetRestsAtTheStart) {
  const Motion motion(one_coupled_body());
  EXPECT_EQ(motion.target(0, 1.0).X_WD.p, Vec3(1, 2, 3));
  EXPECT_EQ(motion.target(0, 1.0).V_WD.v, Vec3::Zero());
}

TEST(Motion, TableIsFourthOrderAccurate) {
  for (const double jitter : {0.0, 0.3}) {
    const Motion exact = built_in();
    const WorstErrors coarse = compare(sampled(0.04, jitter), exact, 2),
                      fine = compare(sampled(0.01, jitter), exact, 2);
    const auto order = [](double a, double b) { return std::log(a / b) / std::log(4.0); };
    EXPECT_GT(order(coarse.p, fine.p), 3.7) << coarse.p << " " << fine.p;
    EXPECT_GT(order(coarse.q, fine.q), 3.7) << coarse.q << " " << fine.q;
    EXPECT_GT(order(coarse.v, fine.v), 2.7) << coarse.v << " " << fine.v;
    EXPECT_GT(order(coarse.w, fine.w), 2.7) << coarse.w << " " << fine.w;
    EXPECT_LT(fine.p, 1e-7);
    EXPECT_LT(fine.q, 1e-6);
  }
}

TEST(Motion, TableTwistIsTheDerivativeOfItsPoseAndContinuous) {
  const Motion motion = sampled(0.05, 0.3);
  for (double t = 0.011; t < 1.98; t += 0.0173) {
    const Twist V = motion.target(0, t).V_WD, D = difference_twist(motion, t, 1e-5);
    EXPECT_LT((V.v - D.v).norm(), 1e-4) << t;
    EXPECT_LT((V.w - D.w).norm(), 1e-3) << t;
  }
  const Motion even = sampled(0.05, 0);
  for (int i = 1; i < 40; ++i) {
    const Twist before = even.target(0, 0.05 * i - 1e-9).V_WD, after = even.target(0, 0.05 * i + 1e-9).V_WD;
    EXPECT_LT((before.v - after.v).norm(), 1e-6);
    EXPECT_LT((before.w - after.w).norm(), 1e-6);
  }
}

TEST(Motion, RestsOutsideTheTable) {
  const std::string csv = pose_header + "1,0,0,0,1,0,0,0\n2,1,0,0,0,1,0,0\n";
  const Motion motion = *Motion::parse(csv, "m.csv", one_coupled_body()).motion;
  EXPECT_EQ(motion.end(), 2.0);
  EXPECT_EQ(motion.target(0, 0.5).X_WD.p.x(), 0);
  EXPECT_EQ(motion.target(0, 0.5).V_WD.v.x(), 0);
  EXPECT_EQ(motion.target(0, 3).X_WD.p.x(), 1);
  EXPECT_EQ(motion.target(0, 3).V_WD.w.norm(), 0);
  EXPECT_NEAR(motion.target(0, 2).X_WD.p.x(), 1, 1e-15);
  EXPECT_TRUE(std::isfinite(motion.target(0, std::nan("")).X_WD.p.x()));
}

TEST(Motion, FastSpinKeepsItsDirection) {
  std::string csv = pose_header;  // 1000 rad/s, one radian per sample
  for (int i = 0; i <= 50; ++i) {
    const double half = 0.5 * i;
    csv += row(1e-3 * i, {Vec3::Zero(), Quat(std::cos(half), 0, 0, std::sin(half))});
  }
  const Motion motion = *Motion::parse(csv, "m.csv", one_coupled_body()).motion;
  for (double t = 0; t < 0.05; t += 1.3e-4) EXPECT_NEAR(motion.target(0, t).V_WD.w.z(), 1000, 1e-6);
}

/// Robot logs repeat a sample until the next one comes, which appears as steps to an interpolator.
TEST(Motion, HeldSamplesOvershootLittle) {
  std::string csv = pose_header;
  for (int i = 0; i < 60; ++i) {
    const int third = i / 3;
    const double x = 0.001 * third, t = 0.004 * i + (i % 2 ? 0.0015 : 0);
    csv += row(t, {Vec3(x, 0, 0), Quat(std::cos(0.5 * x), std::sin(0.5 * x), 0, 0)});
  }
  const Motion motion = *Motion::parse(csv, "m.csv", one_coupled_body()).motion;
  for (double t = 0; t < 0.23; t += 1e-4) {
    const double held = 0.001 * std::floor(t / 0.012);
    EXPECT_NEAR(motion.target(0, t).X_WD.p.x(), held, 0.0013) << t;
    EXPECT_LT(motion.target(0, t).V_WD.v.norm(), 0.001 / 0.0025 * 2) << t;
  }
}

/// Rest, a quick move, rest: between two samples the curve stays between them, however long the neighbouring
/// intervals are.
TEST(Motion, UnevenSamplesAreNotOvershot) {
  for (const double quick : {0.01, 0.001}) {
    const double length = quick == 0.01 ? 0.01 : 1;  // m
    std::string csv = pose_header;
    const auto at = [&](double t, double x) {
      csv += row(t, {Vec3(x, 0, 0), Quat(std::cos(0.5 * x), 0, std::sin(0.5 * x), 0)});
    };
    at(0, 0);
    at(1, 0);
    at(1 + quick, length);
    at(3, length);
    const Motion motion = *Motion::parse(csv, "m.csv", one_coupled_body()).motion;
    for (double t = 0; t < 3; t += quick / 7) {
      const Target target = motion.target(0, t);
      EXPECT_GE(target.X_WD.p.x(), -1e-12) << t;
      EXPECT_LE(target.X_WD.p.x(), length * (1 + 1e-12)) << t;
      const double turn = 2 * std::atan2(target.X_WD.q.y(), target.X_WD.q.w());
      EXPECT_GE(turn, -1e-9) << t;
      EXPECT_LE(turn, length * (1 + 1e-9)) << t;
      EXPECT_LE(target.V_WD.v.norm(), 1.5 * length / quick * (1 + 1e-9)) << t;
    }
  }
}

TEST(Motion, UnevenSamplesOfAnyKindStayBetweenTheirNeighbours) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> exponent(-3, 0);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    std::string csv = pose_header;
    std::vector<double> t, x;
    Real at = 0;
    for (int i = 0; i < 30; ++i) {
      t.push_back(at);
      at += std::pow(10, exponent(engine));
      x.push_back(0.1 * normal(engine));
      csv += row(t.back(), {Vec3(x.back(), 0, 0), Quat::Identity()});
    }
    const Motion motion = *Motion::parse(csv, "m.csv", one_coupled_body()).motion;
    const TimeGrid grid(t);
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
      if (grid.is_even_at(i) || grid.is_even_at(i + 1)) continue;
      const auto [low, high] = std::minmax(x[i], x[i + 1]);
      for (double s = 0; s <= 1; s += 0.05) {
        const double value = motion.target(0, t[i] + s * (t[i + 1] - t[i])).X_WD.p.x();
        EXPECT_GE(value, low - 1e-9);
        EXPECT_LE(value, high + 1e-9);
      }
    }
  }
}

TEST(Motion, WrenchColumnsDriveAnAdmittanceDevice) {
  SceneConfig scene = one_coupled_body();
  scene.bodies[0].coupling.reset();
  scene.device =
      DeviceConfig{.name = "d", .kind = DeviceKind::admittance, .limits = {}, .rig = {}, .plant = {}};
  const MotionResult result = Motion::parse(
      "t,tool.fx,tool.fy,tool.fz,tool.tx,tool.ty,tool.tz\n0,0,1,2,3,4,5\n1,1,1,2,3,4,5\n", "m.csv", scene);
  ASSERT_THAT(result.errors, IsEmpty());
  EXPECT_NEAR(result.motion->wrench(0, 0.25).f.x(), 0.25, 1e-12);
  EXPECT_NEAR(result.motion->wrench(0, 0.25).tau.z(), 5, 1e-12);
  EXPECT_EQ(result.motion->wrench(0, 9).f.x(), 1);
}

TEST(Motion, JointColumnsGiveTheHandlePose) {
  SceneConfig scene = one_coupled_body();
  RigParams rig;
  rig.tree.joints = {{.name = "slide", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitX()},
                     {.name = "turn", .axis_J = Vec3::UnitZ()}};
  rig.tree.handles = {{.body = "tool", .joint = "turn", .X_LH = {Vec3(0, 0.1, 0), Quat::Identity()}}};
  scene.device =
      DeviceConfig{.name = "d", .kind = DeviceKind::non_haptic, .limits = {}, .rig = rig, .plant = {}};
  const MotionResult result = Motion::parse("t,slide,turn\n0,0,0\n1,0.5,1\n2,1,2\n", "m.csv", scene);
  ASSERT_THAT(result.errors, IsEmpty());
  ASSERT_TRUE(result.motion->has_joints());
  EXPECT_NEAR(result.motion->joints(1.5).q[0], 0.75, 1e-12);
  EXPECT_NEAR(result.motion->joints(1.5).q_dot[1], 1, 1e-12);
  const Target sample = result.motion->target(0, 1);
  EXPECT_NEAR((sample.X_WD.p - Vec3(0.5 - 0.1 * std::sin(1), 0.1 * std::cos(1), 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(sample.V_WD.w.z(), 1, 1e-12);
}

TEST(Motion, JointColumnsDriveEveryBodyThatHasAHandle) {
  SceneConfig scene = one_coupled_body();  // "tool" has no handle: it rests
  for (const char* name : {"left", "right"}) {
    scene.bodies.push_back(scene.bodies.front());
    scene.bodies.back().name = name;
  }
  RigParams rig;
  rig.tree.joints = {{.name = "slide", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitX()},
                     {.name = "jaw_left", .axis_J = Vec3::UnitZ()},
                     {.name = "jaw_right", .parent = "slide", .axis_J = -Vec3::UnitZ()}};
  const Pose at_the_tip{Vec3(0, 0.1, 0), Quat::Identity()};
  rig.tree.handles = {{.body = "right", .joint = "jaw_right", .X_LH = at_the_tip},
                      {.body = "left", .joint = "jaw_left", .X_LH = at_the_tip}};
  scene.device =
      DeviceConfig{.name = "d", .kind = DeviceKind::non_haptic, .limits = {}, .rig = rig, .plant = {}};
  const MotionResult result =
      Motion::parse("t,slide,jaw_left,jaw_right\n0,0,0,0\n1,0.5,1,2\n2,1,2,4\n", "m.csv", scene);
  ASSERT_THAT(result.errors, IsEmpty());
  EXPECT_EQ(result.motion->target(0, 1).X_WD.p, Vec3(1, 2, 3));
  const Target left = result.motion->target(1, 1), right = result.motion->target(2, 1);
  EXPECT_LT((left.X_WD.p - Vec3(0.5 - 0.1 * std::sin(1), 0.1 * std::cos(1), 0)).norm(), 1e-12);
  EXPECT_LT((right.X_WD.p - Vec3(0.5 + 0.1 * std::sin(2), 0.1 * std::cos(2), 0)).norm(), 1e-12);
  EXPECT_LT((left.V_WD.w - Vec3(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((right.V_WD.w - Vec3(0, 0, -2)).norm(), 1e-12);
  EXPECT_LT((right.V_WD.v - Vec3(0.5 + 0.2 * std::cos(2), -0.2 * std::sin(2), 0)).norm(), 1e-12);
}

TEST(Motion, TheScenesOwnMotionOfJointsMovesTheHandles) {
  SceneConfig scene = one_coupled_body();
  RigParams rig;
  rig.tree.joints = {{.name = "slide", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitX()},
                     {.name = "still", .axis_J = Vec3::UnitY()},
                     {.name = "turn", .axis_J = Vec3::UnitZ()}};
  rig.tree.handles = {{.body = "tool", .joint = "turn", .X_LH = {Vec3(0, 0.1, 0), Quat::Identity()}}};
  scene.device =
      DeviceConfig{.name = "d", .kind = DeviceKind::non_haptic, .limits = {}, .rig = rig, .plant = {}};
  scene.motion = MotionConfig{};
  scene.motion->joints = {
      {.coordinate = "turn", .amplitude = 0.5, .frequency_hz = 2, .phase = 0.3},
      {.coordinate = "slide", .offset = 0.2, .amplitude = 0.1, .frequency_hz = 1, .phase = 0}};
  const Motion motion(scene);
  ASSERT_TRUE(motion.has_joints());
  EXPECT_FALSE(motion.end().has_value());
  for (double t = 0; t < 1; t += 0.093) {
    const JointTarget hand = motion.joints(t);
    EXPECT_NEAR(hand.q[0], 0.2 + 0.1 * std::sin(2 * std::numbers::pi * t), 1e-14);
    EXPECT_EQ(hand.q[1], 0);
    EXPECT_NEAR(hand.q[2], 0.5 * std::sin(4 * std::numbers::pi * t + 0.3), 1e-14);
    const Pose X = motion.target(0, t).X_WD;
    EXPECT_LT((X.p - Vec3(hand.q[0] - 0.1 * std::sin(hand.q[2]), 0.1 * std::cos(hand.q[2]), 0)).norm(),
              1e-14);
    const Twist V = motion.target(0, t).V_WD, D = difference_twist(motion, t, 1e-5);
    EXPECT_LT((V.v - D.v).norm(), 1e-6) << t;
    EXPECT_LT((V.w - D.w).norm(), 1e-6) << t;
  }
  const MotionResult table = Motion::parse("t,slide,still,turn\n0,1,0,0\n1,1,0,0\n", "m.csv", scene);
  ASSERT_THAT(table.errors, IsEmpty());
  EXPECT_EQ(table.motion->joints(0.4).q[0], 1);
  EXPECT_EQ(table.motion->target(0, 0.4).V_WD.w.norm(), 0);
  const MotionResult poses = Motion::parse(pose_header + "0,7,0,0,1,0,0,0\n", "m.csv", scene);
  ASSERT_THAT(poses.errors, IsEmpty());
  EXPECT_FALSE(poses.motion->has_joints());
  EXPECT_EQ(poses.motion->target(0, 0).X_WD.p.x(), 7);
}

TEST(Motion, BadTablesAreRefusedWithTheirPlace) {
  const auto errors = [](const std::string& csv) {
    return Motion::parse(csv, "m.csv", one_coupled_body()).errors;
  };
  EXPECT_THAT(errors("t,tool.x\n0,0\n"), Contains(HasSubstr("m.csv:1:1: column 'tool.y' is missing")));
  EXPECT_THAT(errors(pose_header + "0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n"),
              ElementsAre(HasSubstr("m.csv:3:1: times must be")));
  EXPECT_THAT(errors(pose_header + "0,0,0,0,1,0,0,0\n1e-310,1,0,0,1,0,0,0\n"),
              ElementsAre(HasSubstr("m.csv:3:1: times must be finite and at least 1 us apart")));
  EXPECT_THAT(errors(pose_header + "1e308,0,0,0,1,0,0,0\n"), ElementsAre(HasSubstr("within 1e9 s")));
  EXPECT_THAT(errors(pose_header + "0,0,0,0,1,1,0,0\n"),
              ElementsAre(AllOf(HasSubstr("m.csv:2:9:"), HasSubstr("norm is 1.414"))));
  EXPECT_THAT(errors(pose_header + "0,0,nan,0,1,0,0,0\n"),
              ElementsAre(HasSubstr("m.csv:2:5: 'tool.y' must be finite")));
  EXPECT_THAT(errors(pose_header + "0,0,here,0,1,0,0,0\n"),
              ElementsAre(HasSubstr("m.csv:2:5: 'here' is not a number")));
  EXPECT_THAT(errors(pose_header + "0,0,0\n"),
              ElementsAre(HasSubstr("m.csv:2:1: has 3 values, the header 8")));
  EXPECT_THAT(errors(pose_header), ElementsAre(HasSubstr("no samples")));
  EXPECT_THAT(errors(""), ElementsAre(HasSubstr("the header line is missing")));
  EXPECT_THAT(Motion::read("no/such.csv", one_coupled_body()).errors,
              ElementsAre(HasSubstr("no/such.csv: cannot be read")));
}

TEST(Motion, SwitchesHoldFromSampleToSample) {
  const std::string header =
      "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz,tool.clutch,tool.engaged\n";
  const MotionResult result =
      Motion::parse(header + "1,0,0,0,1,0,0,0,1,0\n2,1,0,0,1,0,0,0,0,1\n3,0,0,0,1,0,0,0,1,1\n", "m.csv",
                    one_coupled_body());
  ASSERT_THAT(result.errors, IsEmpty());
  const auto at = [&](double t) {
    const MotionSwitches switches = result.motion->switches(0, t);
    return std::pair(switches.engaged, switches.clutch);
  };
  EXPECT_EQ(at(0), std::pair(false, true));  // as in the first sample
  EXPECT_EQ(at(1.999), std::pair(false, true));
  EXPECT_EQ(at(2), std::pair(true, false));
  EXPECT_EQ(at(2.999), std::pair(true, false));
  EXPECT_EQ(at(3), std::pair(true, true));
  EXPECT_EQ(at(9), std::pair(true, true));
  EXPECT_EQ(at(std::nan("")), std::pair(false, true));
  EXPECT_EQ(result.motion->target(0, 2).X_WD.p.x(), 1);
  EXPECT_EQ(result.motion->end(), 3.0);
}

TEST(Motion, SwitchesThatAreNotGivenAreOn) {
  const std::string csv = "t,tool.engaged\n0,0\n1,0\n";
  EXPECT_TRUE(Motion::parse(csv, "m.csv", one_coupled_body()).motion->switches(0, 0.5).clutch);
  SceneConfig two = one_coupled_body();
  two.bodies.push_back(two.bodies.front());
  two.bodies.back().name = "other";
  const Motion motion = *Motion::parse(csv, "m.csv", two).motion;
  EXPECT_FALSE(motion.switches(0, 0.5).engaged);
  EXPECT_TRUE(motion.switches(1, 0.5).engaged);
  EXPECT_TRUE(built_in().switches(0, 0.5).engaged);
}

TEST(Motion, ATableOfSwitchesAloneLeavesTheTargetToTheScene) {
  SceneConfig scene = one_coupled_body();
  scene.motion = six_dof();
  scene.motion->force_amplitude = Vec3(1, 2, 3);
  const MotionResult result = Motion::parse("t,tool.engaged\n0,1\n1,0\n", "m.csv", scene);
  ASSERT_THAT(result.errors, IsEmpty());
  ASSERT_THAT(result.notes, IsEmpty());
  const Motion own(scene);
  for (const double t : {0.0, 0.7, 1.3}) {
    EXPECT_EQ(result.motion->target(0, t).X_WD.p, own.target(0, t).X_WD.p);
    EXPECT_EQ(result.motion->target(0, t).V_WD.w, own.target(0, t).V_WD.w);
    EXPECT_EQ(result.motion->wrench(0, t).f, own.wrench(0, t).f);
  }
  EXPECT_FALSE(result.motion->switches(0, 1.3).engaged);
  EXPECT_FALSE(result.motion->end().has_value());  // the scene's duration holds
}

TEST(Motion, BadSwitchesAreRefusedWithTheirPlace) {
  const auto errors = [](const std::string& csv) {
    return Motion::parse(csv, "m.csv", one_coupled_body()).errors;
  };
  EXPECT_THAT(errors("t,tool.engaged,tool.clutch\n0,1,2\n1,0.5,1\n2,-1,nan\n"),
              ElementsAre(HasSubstr("m.csv:2:5: 'tool.clutch' must be 0 or 1"),
                          HasSubstr("m.csv:3:3: 'tool.engaged' must be 0 or 1"),
                          HasSubstr("m.csv:4:3: 'tool.engaged' must be 0 or 1"),
                          HasSubstr("m.csv:4:6: 'tool.clutch' must be 0 or 1")));
  EXPECT_THAT(errors("t,tool.engaged,tool.x\n0,1,0\n"), Contains(HasSubstr("column 'tool.y' is missing")));
  EXPECT_THAT(errors("t,tool.engage\n0,1\n"), Contains(HasSubstr("column 'tool.x' is missing")));
}

TEST(Motion, AClutchIsNotedWhereTheDeviceHasNone) {
  SceneConfig scene = one_coupled_body();
  const std::string csv = "t,tool.clutch\n0,1\n";
  EXPECT_THAT(Motion::parse(csv, "m.csv", scene).notes,
              ElementsAre(HasSubstr("'tool.clutch' has no effect")));
  scene.device =
      DeviceConfig{.name = "d", .kind = DeviceKind::relative, .limits = {}, .rig = {}, .plant = {}};
  EXPECT_THAT(Motion::parse(csv, "m.csv", scene).notes, IsEmpty());
}

TEST(Motion, OtherColumnsAreNoted) {
  const MotionResult result =
      Motion::parse("t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz,jaw\n0,0,0,0,1,0,0,0,7\n",
                    "m.csv", one_coupled_body());
  ASSERT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(result.notes, ElementsAre(HasSubstr("column 'jaw' is not used")));
}

/// Returns the note, if any, for samples of x at every 1 ms.
std::vector<std::string> notes_on(const std::vector<double>& x) {
  std::string csv = "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n";
  for (std::size_t i = 0; i < x.size(); ++i)
    csv += std::to_string(0.001 * static_cast<double>(i)) + "," + std::to_string(x[i]) + ",0,0,1,0,0,0\n";
  return Motion::parse(csv, "m.csv", one_coupled_body()).notes;
}

TEST(Motion, SuddenMovesAreNoted) {
  EXPECT_THAT(notes_on({0, 0.001, 0.002, 0.003, 0.004}), IsEmpty());
  EXPECT_THAT(notes_on({0, 0, 0, 0.002, 0.004, 0.006}), IsEmpty());       // starts moving
  EXPECT_THAT(notes_on({0, 0.0001, 0.0002, 0.0008, 0.0009}), IsEmpty());  // slow
  EXPECT_THAT(
      notes_on({0, 0.001, 0.002, 1.003, 1.004, 1.005}),
      ElementsAre(HasSubstr("m.csv:5:10: 'tool' moves by 1 m in 0.001 s, more than 10 times as fast")));
  EXPECT_THAT(notes_on({0, 0.001, 0.5, 0.003, 0.004, 0.005}),  // there and back
              ElementsAre(HasSubstr("m.csv:4:10: 'tool' moves by 0.499 m in 0.001 s")));
  EXPECT_THAT(notes_on({0, 1}), IsEmpty());
}

std::string shared_dir() {
  const char* from_environment = std::getenv("GODOBJECT_SHARED");
  return from_environment ? from_environment : GODOBJECT_SOURCE_DIR "/../shared";
}

/// A target that starts with the tool has the velocities of the reference's case.json.
TEST(Motion, ReferenceMotionHasTheStatedVelocities) {
  const std::string path = shared_dir() + "/reference/coupling-lissajous/motion.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const MotionResult result = Motion::read(path, one_coupled_body());
  ASSERT_THAT(result.errors, IsEmpty());
  const Twist V = result.motion->target(0, 0).V_WD;
  EXPECT_LT((V.v - Vec3(0.314159265359, 0.376167798795, 0.131946891451)).norm(), 1e-8);
  EXPECT_LT((V.w - Vec3(3.76991118431, 3.45575191895, 6.78584013175)).norm(), 1e-6);
}

/// Between two samples 2 ms apart the curve must meet the reference's omitted sample.
TEST(Motion, ReferenceMotionPredictsTheSamplesLeftOut) {
  const std::string path = shared_dir() + "/reference/coupling-lissajous/motion.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const CsvTable all = *read_csv(path).table;
  const auto pose = [&](std::size_t i) {
    return Pose{Vec3(all.at(i, 1), all.at(i, 2), all.at(i, 3)),
                Quat(all.at(i, 4), all.at(i, 5), all.at(i, 6), all.at(i, 7))};
  };
  std::string csv = pose_header;
  for (std::size_t i = 0; i < all.num_rows(); i += 2) csv += row(all.at(i, 0), pose(i));
  const Motion motion = *Motion::parse(csv, "half.csv", one_coupled_body()).motion;
  double worst_p = 0, worst_q = 0;
  for (std::size_t i = 1; i + 1 < all.num_rows(); i += 2) {
    const Pose X = motion.target(0, all.at(i, 0)).X_WD;
    worst_p = std::max(worst_p, (X.p - pose(i).p).norm());
    worst_q = std::max(worst_q, angle_between(X.q, pose(i).q));
  }
  EXPECT_LT(worst_p, 1e-10);
  EXPECT_LT(worst_q, 1e-8);
}

/// The recorded teleoperation, made into a motion by the tool beside it.
TEST(Motion, RecordedTeleoperationStaysBounded) {
  const std::string tool = shared_dir() + "/tools/desk_to_motion.py";
  const std::string data = shared_dir() + "/data/desk_taurus/S5_T2_left_kinematics.txt";
  if (!std::filesystem::exists(tool) || !std::filesystem::exists(data)) GTEST_SKIP() << "no " << data;
  const std::string path = testing::TempDir() + "/godobject_desk_motion.csv";
  const std::string command = "python3 '" + tool + "' pose '" + data + "' > '" + path + "'";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "cannot run python3";
  const MotionResult result = Motion::read(path, one_coupled_body());
  ASSERT_THAT(result.errors, IsEmpty());
  const CsvTable table = *read_csv(path).table;
  double overshoot = 0, speed = 0, turn_speed = 0;
  for (std::size_t i = 0; i + 1 < table.num_rows(); ++i) {
    const auto p = [&](std::size_t k) { return Vec3(table.at(k, 1), table.at(k, 2), table.at(k, 3)); };
    const double t = table.at(i, 0), h = table.at(i + 1, 0) - t;
    for (const double s : {0.25, 0.5, 0.75}) {
      const Target sample = result.motion->target(0, t + s * h);
      const Vec3 chord = p(i + 1) - p(i);
      overshoot = std::max(overshoot, (sample.X_WD.p - p(i) - s * chord).norm());
      speed = std::max(speed, sample.V_WD.v.norm());
      turn_speed = std::max(turn_speed, sample.V_WD.w.norm());
    }
  }
  RecordProperty("overshoot_um", std::to_string(1e6 * overshoot));
  std::cout << "off the chord " << overshoot << " m, speed " << speed << " m/s, turning " << turn_speed
            << " rad/s\n";
  EXPECT_LT(overshoot, 3e-4);  // the largest step between samples is 6e-4 m
  EXPECT_LT(speed, 0.5);
  EXPECT_LT(turn_speed, 10);
}

}  // namespace
}  // namespace godobject::test_motion
