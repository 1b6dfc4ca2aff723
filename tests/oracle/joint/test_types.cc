// Constraints, freedoms and energy of every type of joint; and the rules of a tree.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>

#include <gtest/gtest.h>

#include "tests/oracle/compare.h"
#include "tests/oracle/dynamics.h"
#include "tests/oracle/energy.h"
#include "tests/oracle/joint/rows.h"
#include "tests/oracle/validate.h"

namespace godobject::oracle::test_joint_types {
namespace {

Quaterniond turn(const Vector3d& axis, double angle) { return Quaterniond(Eigen::AngleAxisd(angle, axis)); }

Body link(const std::string& name, double m) {
  Body body;
  body.name = name;
  body.m = m;
  body.I_B << 3.0e-3, 0.4e-3, -0.3e-3, 0.4e-3, 5.0e-3, 0.6e-3, -0.3e-3, 0.6e-3, 6.0e-3;
  body.I_B *= m;
  body.start.q = turn(Vector3d(1, 2, -1).normalized(), 0.7 * m);
  body.start.v = {0.1, -0.2, 0.3};
  body.start.w = {2 * m, 3, -4};
  return body;
}

/// A joint in no special direction. axis_C of a universal one is square to axis_P at angle zero.
Joint skew_joint(JointType type, std::optional<std::size_t> parent, std::size_t child) {
  Joint joint;
  joint.name = "joint of " + std::to_string(child);
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  joint.anchor_P = {0.03, -0.02, 0.10};
  joint.anchor_C = {0.01, 0.04, -0.08};
  joint.axis_P = Vector3d(1, 2, 2) / 3;
  joint.q_PC = turn(Vector3d(2, -1, 2) / 3, 0.9);
  joint.axis_C = joint.q_PC.conjugate() * (Vector3d(2, -2, 1) / 3);
  return joint;
}

/// Shuts the joints, parents first, and lets the start velocities satisfy them.
Case shut(Case problem) {
  for (const Joint& joint : problem.joints) {
    const RigidState P = joint.parent ? problem.bodies[*joint.parent].start : RigidState{};
    RigidState& C = problem.bodies[joint.child].start;
    C.q = P.q * joint.q_PC;
    C.p = P.p + P.q * joint.anchor_P - C.q * joint.anchor_C;
  }
  std::vector<RigidState> states;
  for (const Body& body : problem.bodies) states.push_back(body.start);
  ScalarVector y = pack(states);
  Dynamics(problem).project(0, y);
  for (std::size_t i = 0; i < states.size(); ++i) problem.bodies[i].start = unpack(y)[i];
  return problem;
}

/// Pose of the child's anchor and attitude relative to the parent's side of the joint.
struct JointPose {
  Vector3d d;     // from the parent's anchor, P axes
  Quaterniond q;  // attitude of C in P, less q_PC
};

JointPose joint_pose(const Joint& joint, const std::vector<RigidState>& states) {
  const RigidState P = joint.parent ? states[*joint.parent] : RigidState{};
  const RigidState& C = states[joint.child];
  const Vector3d anchor_C = C.p + C.q * joint.anchor_C;
  return {P.q.conjugate() * (anchor_C - P.p) - joint.anchor_P,
          P.q.conjugate() * C.q * joint.q_PC.conjugate()};
}

/// How far the joint is open (m or rad), written from the pose and not from joint_rows.
double opening(const Joint& joint, const std::vector<RigidState>& states) {
  const JointPose x = joint_pose(joint, states);
  const Vector3d axis = joint.axis_P;
  const Vector3d swing = x.q * axis - axis;
  const Vector3d off_axis = x.d - x.d.dot(axis) * axis;
  switch (joint.type) {
    case JointType::fixed: return std::max(x.d.norm(), 2 * x.q.vec().norm());
    case JointType::ball: return x.d.norm();
    case JointType::hinge: return std::max(x.d.norm(), swing.norm());
    case JointType::slider: return std::max(off_axis.norm(), 2 * x.q.vec().norm());
    case JointType::cylindrical: return std::max(off_axis.norm(), swing.norm());
    case JointType::universal:
      return std::max(x.d.norm(), std::abs(axis.dot(x.q * (joint.q_PC * joint.axis_C))));
  }
  return NAN;
}

double worst_opening(const Case& problem, const Solution& solution) {
  double worst = 0;
  for (const auto& states : solution.states) {
    for (const Joint& joint : problem.joints) worst = larger(opening(joint, states), worst);
  }
  return worst;
}

struct Freedom {
  JointType type;
  const char* name;
  Eigen::Index num_rows;
  bool turns, shifts;
};

void PrintTo(const Freedom& freedom, std::ostream* stream) { *stream << freedom.name; }

class JointTypes : public testing::TestWithParam<Freedom> {};

TEST_P(JointTypes, TwoFloatingBodiesKeepMomentumAndEnergy) {
  const Freedom freedom = GetParam();
  const Case problem =
      shut({.bodies = {link("P", 0.7), link("C", 0.4)}, .joints = {skew_joint(freedom.type, 0, 1)}});
  const Joint& joint = problem.joints[0];
  EXPECT_EQ(num_rows(joint), freedom.num_rows);
  const Solution solution = solve(problem, uniform_times(1, 0.01));

  const std::vector<RigidState>& start = solution.states[0];
  double worst = 0, angle = 0, shift = 0;
  for (const auto& states : solution.states) {
    worst = larger(std::abs(energy(problem, states) / energy(problem, start) - 1), worst);
    worst = larger((momentum(problem, states) - momentum(problem, start)).norm(), worst);
    worst = larger((angular_momentum(problem, states) - angular_momentum(problem, start)).norm(), worst);
    angle = std::max(joint_pose(joint, states).q.angularDistance(Quaterniond::Identity()), angle);
    shift = std::max(joint_pose(joint, states).d.norm(), shift);
  }
  EXPECT_LT(worst, 1e-12);
  EXPECT_LT(worst_opening(problem, solution), 1e-14);
  EXPECT_LT(solution.joint_drift, 1e-12);
  EXPECT_EQ(angle > 0.1, freedom.turns);
  EXPECT_EQ(shift > 0.02, freedom.shifts);
}

TEST_P(JointTypes, ExertNothingAlongWhatTheyLeaveFree) {
  const JointType type = GetParam().type;
  const Case problem =
      shut({.gravity = {0, 0, -9.81},
            .bodies = {link("P", 0.7), link("C", 0.4)},
            .joints = {skew_joint(JointType::ball, std::nullopt, 0), skew_joint(type, 0, 1)}});
  const Joint& joint = problem.joints[1];
  const Solution solution = solve(problem, uniform_times(0.5, 0.05));
  for (std::size_t i = 0; i < solution.times.size(); ++i) {
    const std::vector<RigidState>& states = solution.states[i];
    const JointWrench on_child = solution.reactions[i][1];
    const Vector3d axis = states[0].q * joint.axis_P, axis_C = states[1].q * joint.axis_C;
    EXPECT_GT(on_child.f.norm(), 0.01);
    EXPECT_LT(solution.reactions[i][0].tau.norm(), 1e-14);
    if (type == JointType::ball) {
      EXPECT_LT(on_child.tau.norm(), 1e-14);
    }
    if (type == JointType::hinge || type == JointType::cylindrical) {
      EXPECT_LT(std::abs(on_child.tau.dot(axis)), 1e-14);
    }
    if (type == JointType::slider || type == JointType::cylindrical) {
      EXPECT_LT(std::abs(on_child.f.dot(axis)), 1e-14);
    }
    if (type == JointType::universal) {
      EXPECT_LT(std::abs(on_child.tau.dot(axis)), 1e-14);
      EXPECT_LT(std::abs(on_child.tau.dot(axis_C)), 1e-14);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, JointTypes,
                         testing::Values(Freedom{JointType::fixed, "fixed", 6, false, false},
                                         Freedom{JointType::ball, "ball", 3, true, false},
                                         Freedom{JointType::hinge, "hinge", 5, true, false},
                                         Freedom{JointType::slider, "slider", 5, false, true},
                                         Freedom{JointType::cylindrical, "cylindrical", 4, true, true},
                                         Freedom{JointType::universal, "universal", 4, true, false}),
                         [](const auto& tested) { return tested.param.name; });

/// All types in one tree with branches, on the world by a universal joint.
Case branched_tree() {
  Case problem;
  problem.gravity = {0, 0, -9.81};
  for (const double m : {0.7, 0.4, 0.5, 0.3, 0.6, 0.2}) problem.bodies.push_back(link("link", m));
  problem.joints = {skew_joint(JointType::universal, std::nullopt, 0),
                    skew_joint(JointType::ball, 0, 1),
                    skew_joint(JointType::hinge, 0, 2),
                    skew_joint(JointType::cylindrical, 2, 3),
                    skew_joint(JointType::slider, 1, 4),
                    skew_joint(JointType::fixed, 3, 5)};
  return shut(problem);
}

TEST(JointTree, KeepsItsEnergy) {
  const Case problem = branched_tree();
  const Solution solution = solve(problem, uniform_times(1, 0.05));
  double worst = 0, scale = 0;
  for (const auto& states : solution.states) {
    worst = larger(std::abs(energy(problem, states) - energy(problem, solution.states[0])), worst);
    scale = std::max(kinetic_energy(problem, states), scale);
  }
  std::printf("tree of six joints, 1 s: relative change of energy %.1e, drift %.1e, joints open by %.1e\n",
              worst / scale, solution.joint_drift, worst_opening(problem, solution));
  EXPECT_LT(worst / scale, 1e-12);
  EXPECT_LT(solution.joint_drift, 1e-11);
  EXPECT_LT(worst_opening(problem, solution), 1e-14);
}

TEST(JointTree, DoesNotDependOnTheTolerance) {
  const Case problem = branched_tree();
  const std::vector<double> times = uniform_times(1, 0.05);
  const WorstDifference worst = worst_difference(solve(problem, times, 1e-11), solve(problem, times, 1e-14));
  std::printf("tree of six joints, 1 s, tolerance 1e-11 against 1e-14: p %.1e m, q %.1e, v %.1e, w %.1e\n",
              worst.p, worst.q, worst.v, worst.w);
  EXPECT_LT(worst.p, 1e-10);
  EXPECT_LT(worst.q, 1e-10);
  EXPECT_LT(worst.v, 1e-9);
  EXPECT_LT(worst.w, 1e-8);
}

TEST(JointTree, DriftStaysSmallWithoutAProjectionBetween) {
  const Case problem = branched_tree();
  EXPECT_LT(solve(problem, std::vector{1.0}).joint_drift, 1e-10);
}

/// The message that refuses a case.
std::string refusal(const Case& problem) {
  try {
    validate(problem);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(JointRules, AreRefusedByName) {
  const Case good = branched_tree();
  EXPECT_EQ(refusal(good), "");
  Case bad = good;
  bad.joints[0].parent = 3;
  EXPECT_NE(refusal(bad).find("'joint of 0': it is part of a loop"), std::string::npos);
  bad = good;
  bad.joints[4].child = 2;
  EXPECT_NE(refusal(bad).find("'joint of 4': its child already has the joint 'joint of 2'"),
            std::string::npos);
  bad = good;
  bad.bodies[3].start.p += 1e-5 * Vector3d::Ones();
  EXPECT_NE(refusal(bad).find("'joint of 3': it is open"), std::string::npos);
  bad = good;
  bad.bodies[5].start.w.x() += 1e-3;
  EXPECT_NE(refusal(bad).find("'joint of 5': it is torn"), std::string::npos);
  bad = good;
  bad.joints[1].imposed = ImposedMotion{.at = [](double) { return JointCoordinate{}; }};
  EXPECT_NE(refusal(bad).find("'joint of 1': only a hinge or a slider"), std::string::npos);
  bad = good;
  bad.joints[1].axis_P *= 2;
  EXPECT_NE(refusal(bad).find("'joint of 1': an axis"), std::string::npos);
}

TEST(JointRules, AnAxisMustNotPointAgainstItsPartner) {
  // Every equation of the hinge holds there, too.
  Case problem =
      shut({.bodies = {link("P", 0.7)}, .joints = {skew_joint(JointType::hinge, std::nullopt, 0)}});
  Joint& joint = problem.joints[0];
  joint.q_PC = turn(joint.axis_P.unitOrthogonal(), std::numbers::pi) * joint.q_PC;
  EXPECT_NE(refusal(problem).find("point against each other"), std::string::npos);
}

}  // namespace
}  // namespace godobject::oracle::test_joint_types
