#include "hal/kinematic_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/phantom_arm.h"

namespace godobject {
namespace {

// Six joints of both kinds with oblique axes and frames.
ChainParams oblique_chain() {
  ChainParams chain;
  chain.X_WB = {Vec3(0.1, -0.2, 0.3), Quat(Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()))};
  const ChainJointKind kinds[] = {ChainJointKind::hinge, ChainJointKind::slider, ChainJointKind::hinge,
                                  ChainJointKind::hinge, ChainJointKind::slider, ChainJointKind::hinge};
  for (int i = 0; i < 6; ++i) {
    ChainJoint joint;
    joint.name = "joint" + std::to_string(i);
    joint.kind = kinds[i];
    joint.X_PJ = {Vec3(0.1 * i, 0.05, -0.02 * i),
                  Quat(Eigen::AngleAxisd(0.3 * i, Vec3(i, 1, -1).normalized()))};
    joint.axis_J = Vec3(1, i - 2.5, 0.5 * i).normalized();
    chain.joints.push_back(joint);
  }
  chain.X_LH = {Vec3(0.01, 0.07, 0.11), Quat(Eigen::AngleAxisd(-0.9, Vec3(0, 1, 1).normalized()))};
  return chain;
}

JointVector random_joints(std::mt19937& random, double range) {
  std::uniform_real_distribution<double> uniform(-range, range);
  JointVector q(6);
  for (int i = 0; i < 6; ++i) q(i) = uniform(random);
  return q;
}

TEST(KinematicChain, PhantomArmAtZeroHasItsHandleAtTheOrigin) {
  const Pose X = KinematicChain(test::phantom_arm()).at(JointVector::Zero(6)).X_WH;
  EXPECT_LT(X.p.norm(), 1e-15);
  EXPECT_LT(X.q.angularDistance(Quat::Identity()), 1e-15);
}

TEST(KinematicChain, YawTurnsTheHandleAboutTheBase) {
  JointVector q = JointVector::Zero(6);
  q(0) = 0.5;
  const Pose X = KinematicChain(test::phantom_arm()).at(q).X_WH;
  EXPECT_LT((X.p - Vec3(0.35 * std::cos(0.5) - 0.35, 0.35 * std::sin(0.5), 0)).norm(), 1e-15);
}

TEST(KinematicChain, JacobianAgreesWithNumericDifferences) {
  const KinematicChain chain(oblique_chain());
  std::mt19937 random(1);
  constexpr double step = 1e-6;
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = random_joints(random, 1.5);
    const ChainConfiguration here = chain.at(q);
    for (int i = 0; i < 6; ++i) {
      JointVector q_plus = q, q_minus = q;
      q_plus(i) += step;
      q_minus(i) -= step;
      const Pose plus = chain.at(q_plus).X_WH, minus = chain.at(q_minus).X_WH;
      const Vec3 v = (plus.p - minus.p) / (2 * step);
      const Eigen::AngleAxisd turn(plus.q * minus.q.conjugate());
      const Vec3 w = turn.axis() * turn.angle() / (2 * step);
      EXPECT_LT((here.J.col(i).tail<3>() - v).norm(), 1e-8);
      EXPECT_LT((here.J.col(i).head<3>() - w).norm(), 1e-8);
    }
  }
}

TEST(KinematicChain, JointTorquesDoTheSamePowerAsTheWrench) {
  const KinematicChain chain(oblique_chain());
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const ChainConfiguration here = chain.at(random_joints(random, 1.5));
    const JointVector q_dot = random_joints(random, 3);
    const Twist V = here.twist(q_dot);
    const JointVector numbers = random_joints(random, 10);
    const Wrench F{numbers.head<3>(), numbers.tail<3>()};
    EXPECT_NEAR(F.tau.dot(V.w) + F.f.dot(V.v), here.joint_torques(F).dot(q_dot), 1e-12);
  }
}

}  // namespace
}  // namespace godobject
