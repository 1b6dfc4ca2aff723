#include "hal/joint/kinematic_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/grasper_device.h"
#include "tests/support/phantom_arm.h"

namespace godobject::test_kinematic_tree {
namespace {

constexpr std::size_t num_joints = 8;

std::string numbered(const char* stem, std::size_t i) { return std::string(stem).append(std::to_string(i)); }

// Hinges and sliders with oblique axes and frames. There are branches from a joint, from its child and from
/// the base, and handles on leaves and on links with children.
KinematicTreeParams oblique_tree() {
  KinematicTreeParams tree;
  tree.X_WB = {Vec3(0.1, -0.2, 0.3), Quat(Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()))};
  const bool slides[num_joints] = {false, true, false, false, true, false, true, false};
  const char* parents[num_joints] = {"", "", "", "joint0", "joint3", "base", "joint2", "joint2"};
  for (std::size_t i = 0; i < num_joints; ++i) {
    const auto x = static_cast<double>(i);
    DeviceJoint joint;
    joint.name = numbered("joint", i);
    joint.parent = parents[i];
    joint.kind = slides[i] ? DeviceJointKind::slider : DeviceJointKind::hinge;
    joint.X_PJ = {Vec3(0.1 * x, 0.05, -0.02 * x),
                  Quat(Eigen::AngleAxisd(0.3 * x, Vec3(x, 1, -1).normalized()))};
    joint.axis_J = Vec3(1, x - 2.5, 0.5 * x).normalized();
    tree.joints.push_back(joint);
  }
  for (const std::size_t joint : {6u, 7u, 4u, 2u, 5u, 3u}) {
    const auto x = static_cast<double>(joint);
    HandleParams handle{.body = numbered("body", joint), .joint = numbered("joint", joint)};
    handle.X_LH = {Vec3(0.01 * x, 0.07, 0.11),
                   Quat(Eigen::AngleAxisd(-0.9, Vec3(0, 1, 0.2 * x).normalized()))};
    tree.handles.push_back(handle);
  }
  return tree;
}

JointVector random_joints(std::mt19937& random, double range, std::size_t n = num_joints) {
  std::uniform_real_distribution<double> uniform(-range, range);
  JointVector q(static_cast<Eigen::Index>(n));
  for (double& x : q) x = uniform(random);
  return q;
}

std::vector<Wrench> random_wrenches(std::mt19937& random, std::size_t n) {
  std::vector<Wrench> F;
  for (std::size_t i = 0; i < n; ++i) {
    const JointVector numbers = random_joints(random, 10, 6);
    F.push_back({numbers.head<3>(), numbers.tail<3>()});
  }
  return F;
}

/// Equation (9) as in the paper, on links with independent kinematics. Each link passes its wrench to its
/// parent, from the leaves up; each joint's wrench is then projected on its axis.
class LeavesUp {
 public:
  LeavesUp(const KinematicTreeParams& tree, const JointVector& q) : tree_(tree) {
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      const DeviceJoint& joint = tree.joints[j];
      const Eigen::Isometry3d X_WJ = frame(joint.parent, j) * matrix(joint.X_PJ);
      axes_.push_back(X_WJ.linear() * joint.axis_J);
      const double x = q(static_cast<Eigen::Index>(j));
      frames_.push_back(joint.kind == DeviceJointKind::hinge ? X_WJ * Eigen::AngleAxisd(x, joint.axis_J)
                                                             : X_WJ * Eigen::Translation3d(x * joint.axis_J));
    }
  }

  Eigen::Isometry3d handle(std::size_t i) const {
    return frames_[index(tree_.handles[i].joint)] * matrix(tree_.handles[i].X_LH);
  }

  JointVector torques(const std::vector<Wrench>& F_H_W) const {
    std::vector<Wrench> link(frames_.size());
    const auto hand_over = [&](const Wrench& F, const Vec3& from, std::size_t to) {
      link[to].f += F.f;
      link[to].tau += F.tau + (from - frames_[to].translation()).cross(F.f);
    };
    for (std::size_t i = 0; i < F_H_W.size(); ++i)
      hand_over(F_H_W[i], handle(i).translation(), index(tree_.handles[i].joint));
    JointVector tau(static_cast<Eigen::Index>(frames_.size()));
    for (std::size_t j = frames_.size(); j-- > 0;) {
      const DeviceJoint& joint = tree_.joints[j];
      const bool hinge = joint.kind == DeviceJointKind::hinge;
      tau(static_cast<Eigen::Index>(j)) = axes_[j].dot(hinge ? link[j].tau : link[j].f);
      if (j > 0 && joint.parent != "base")
        hand_over(link[j], frames_[j].translation(), joint.parent.empty() ? j - 1 : index(joint.parent));
    }
    return tau;
  }

 private:
  static Eigen::Isometry3d matrix(const Pose& X) {
    return Eigen::Translation3d(X.p) * Eigen::Quaterniond(X.q);
  }
  std::size_t index(const std::string& name) const {
    for (std::size_t j = 0; j < tree_.joints.size(); ++j)
      if (tree_.joints[j].name == name) return j;
    throw std::runtime_error("no joint " + name);
  }
  Eigen::Isometry3d frame(const std::string& parent, std::size_t j) const {
    if (parent == "base" || (parent.empty() && j == 0)) return matrix(tree_.X_WB);
    return frames_[parent.empty() ? j - 1 : index(parent)];
  }

  KinematicTreeParams tree_;
  std::vector<Vec3> axes_;
  std::vector<Eigen::Isometry3d> frames_;  // of the links, in the world
};

TEST(KinematicTree, PhantomArmAtZeroHasItsHandleAtTheOrigin) {
  const Pose X = KinematicTree(test::phantom_arm()).at(JointVector::Zero(6)).X_WH(0);
  EXPECT_LT(X.p.norm(), 1e-15);
  EXPECT_LT(X.q.angularDistance(Quat::Identity()), 1e-15);
}

TEST(KinematicTree, YawTurnsTheHandleAboutTheBase) {
  JointVector q = JointVector::Zero(6);
  q(0) = 0.5;
  const Pose X = KinematicTree(test::phantom_arm()).at(q).X_WH(0);
  EXPECT_LT((X.p - Vec3(0.35 * std::cos(0.5) - 0.35, 0.35 * std::sin(0.5), 0)).norm(), 1e-15);
}

TEST(KinematicTree, HandlesAreWhereTheFramesOfTheirLinksSay) {
  const KinematicTreeParams params = oblique_tree();
  const KinematicTree tree(params);
  std::mt19937 random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = random_joints(random, 1.5);
    const TreeConfiguration here = tree.at(q);
    const LeavesUp expected(params, q);
    ASSERT_EQ(here.num_handles(), params.handles.size());
    for (std::size_t i = 0; i < here.num_handles(); ++i) {
      EXPECT_LT((here.X_WH(i).p - expected.handle(i).translation()).norm(), 1e-14) << i;
      EXPECT_LT((here.X_WH(i).q.toRotationMatrix() - expected.handle(i).linear()).norm(), 1e-14) << i;
    }
  }
}

TEST(KinematicTree, JacobiansAgreeWithNumericDifferences) {
  const KinematicTree tree(oblique_tree());
  std::mt19937 random(1);
  constexpr double step = 1e-6;
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = random_joints(random, 1.5);
    const TreeConfiguration here = tree.at(q);
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      JointVector q_plus = q, q_minus = q;
      q_plus(j) += step;
      q_minus(j) -= step;
      const TreeConfiguration after = tree.at(q_plus), before = tree.at(q_minus);
      for (std::size_t i = 0; i < here.num_handles(); ++i) {
        const Pose &plus = after.X_WH(i), &minus = before.X_WH(i);
        const Vec3 v = (plus.p - minus.p) / (2 * step);
        const Eigen::AngleAxisd turn(plus.q * minus.q.conjugate());
        const Vec3 w = turn.axis() * turn.angle() / (2 * step);
        const HandleJacobian J = here.jacobian(i);
        EXPECT_LT((J.col(j).tail<3>() - v).norm(), 1e-8) << i << ' ' << j;
        EXPECT_LT((J.col(j).head<3>() - w).norm(), 1e-8) << i << ' ' << j;
      }
    }
  }
}

TEST(KinematicTree, OnlyJointsOnTheWayMoveAHandle) {
  const KinematicTree tree(oblique_tree());
  const auto movers = [&](std::size_t handle) {
    std::vector<std::size_t> joints;
    for (std::size_t j = 0; j < num_joints; ++j)
      if (tree.moves(j, handle)) joints.push_back(j);
    return joints;
  };
  EXPECT_EQ(movers(0), (std::vector<std::size_t>{0, 1, 2, 6}));
  EXPECT_EQ(movers(1), (std::vector<std::size_t>{0, 1, 2, 7}));
  EXPECT_EQ(movers(2), (std::vector<std::size_t>{0, 3, 4}));
  EXPECT_EQ(movers(3), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(movers(4), (std::vector<std::size_t>{5}));
  EXPECT_EQ(movers(5), (std::vector<std::size_t>{0, 3}));
}

TEST(KinematicTree, TwistIsTheJacobianTimesTheRates) {
  const KinematicTree tree(oblique_tree());
  std::mt19937 random(5);
  const TreeConfiguration here = tree.at(random_joints(random, 1.5));
  const JointVector q_dot = random_joints(random, 3);
  for (std::size_t i = 0; i < here.num_handles(); ++i) {
    const Eigen::Matrix<double, 6, 1> V = here.jacobian(i) * q_dot;
    EXPECT_LT((here.twist(i, q_dot).w - V.head<3>()).norm(), 1e-14);
    EXPECT_LT((here.twist(i, q_dot).v - V.tail<3>()).norm(), 1e-14);
  }
}

TEST(KinematicTree, JointTorquesDoTheSamePowerAsAllTheWrenches) {
  const KinematicTree tree(oblique_tree());
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const TreeConfiguration here = tree.at(random_joints(random, 1.5));
    const JointVector q_dot = random_joints(random, 3);
    const std::vector<Wrench> F = random_wrenches(random, here.num_handles());
    double power = 0, gross = 0;
    for (std::size_t i = 0; i < F.size(); ++i) {
      const Twist V = here.twist(i, q_dot);
      power += F[i].tau.dot(V.w) + F[i].f.dot(V.v);
      gross += F[i].tau.norm() * V.w.norm() + F[i].f.norm() * V.v.norm();
    }
    EXPECT_NEAR(power, here.joint_torques(F).dot(q_dot), 1e-12 * std::max(1.0, gross));
  }
}

// tau = - dU/dq with U = - sum m g . p
TEST(KinematicTree, WeightTorquesAreTheGradientOfTheEnergy) {
  KinematicTreeParams params = oblique_tree();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 2);
  params.handles.clear();  // at the centres of mass
  const Vec3 g_W(1, -2, -9);
  for (std::size_t j = 0; j < num_joints; ++j) {
    DeviceJoint& joint = params.joints[j];
    joint.mass = j == 4 ? 0 : uniform(random);
    joint.p_LM = Vec3(uniform(random), -uniform(random), uniform(random));
    params.handles.push_back(
        {.body = joint.name, .joint = joint.name, .X_LH = {joint.p_LM, Quat::Identity()}});
  }
  const KinematicTree tree(params);
  const auto energy = [&](const JointVector& q) {
    const TreeConfiguration at = tree.at(q);
    double U = 0;
    for (std::size_t j = 0; j < num_joints; ++j) U -= params.joints[j].mass * g_W.dot(at.X_WH(j).p);
    return U;
  };
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = random_joints(random, 1.5), tau = tree.at(q).weight_torques(g_W);
    for (Eigen::Index j = 0; j < tau.size(); ++j) {
      JointVector before = q, after = q;
      before(j) -= 1e-5;
      after(j) += 1e-5;
      EXPECT_NEAR(tau(j), -(energy(after) - energy(before)) / 2e-5, 1e-6) << j;
    }
  }
}

TEST(KinematicTree, JointTorquesAreEquation9FromTheLeavesUp) {
  std::mt19937 random(3);
  for (const KinematicTreeParams& params : {oblique_tree(), test::grasper_tree(), test::phantom_arm()}) {
    const KinematicTree tree(params);
    for (int trial = 0; trial < 20; ++trial) {
      const JointVector q = random_joints(random, 1.5, params.joints.size());
      const std::vector<Wrench> F = random_wrenches(random, params.handles.size());
      const JointVector expected = LeavesUp(params, q).torques(F);
      EXPECT_LT((tree.at(q).joint_torques(F) - expected).norm(), 1e-13 * (1 + expected.norm()));
    }
  }
}

TEST(KinematicTree, HandlesWithoutAWrenchAreNotLoaded) {
  const KinematicTree tree(oblique_tree());
  std::mt19937 random(6);
  const TreeConfiguration here = tree.at(random_joints(random, 1.5));
  std::vector<Wrench> F = random_wrenches(random, here.num_handles() + 1);
  const JointVector too_many = here.joint_torques(F), all = here.joint_torques(std::span(F).first(6));
  EXPECT_EQ(too_many, all);
  const JointVector two = here.joint_torques(std::span(F).first(2));
  std::fill(F.begin() + 2, F.end(), Wrench{});
  EXPECT_EQ(two, here.joint_torques(F));
  EXPECT_EQ(here.joint_torques({}), JointVector(JointVector::Zero(num_joints)));
}

TEST(KinematicTree, ParentsAreTheJointBeforeUnlessNamed) {
  const KinematicTreeParams tree = oblique_tree();
  EXPECT_EQ(parent_link(tree.joints, 0), 0u);
  EXPECT_EQ(parent_link(tree.joints, 1), 1u);
  EXPECT_EQ(parent_link(tree.joints, 3), 1u);
  EXPECT_EQ(parent_link(tree.joints, 5), 0u);
  KinematicTreeParams wrong = tree;
  wrong.joints[3].parent = "joint4";
  EXPECT_EQ(parent_link(wrong.joints, 3), std::nullopt);
}

TEST(KinematicTree, HoldsItsCapacitiesOfJointsAndHandles) {
  KinematicTreeParams params;
  for (std::size_t j = 0; j < max_joints; ++j)
    params.joints.push_back({.name = numbered("j", j), .X_PJ = {Vec3(1, 0, 0), Quat::Identity()}});
  for (std::size_t i = 0; i < max_handles; ++i)
    params.handles.push_back({.body = numbered("b", i), .joint = numbered("j", 2 * i + 1)});
  const KinematicTree tree(params);
  const TreeConfiguration here = tree.at(JointVector::Zero(max_joints));
  for (std::size_t i = 0; i < max_handles; ++i) EXPECT_EQ(here.X_WH(i).p.x(), static_cast<double>(2 * i + 2));
  const std::vector<Wrench> F(max_handles, {Vec3(0, 0, 1), Vec3::Zero()});
  for (std::size_t j = 0; j < max_joints; ++j) {
    const std::size_t beyond = max_handles - j / 2;
    EXPECT_EQ(here.joint_torques(F)(static_cast<Eigen::Index>(j)), static_cast<double>(beyond));
  }
}

}  // namespace
}  // namespace godobject::test_kinematic_tree
