#include "hal/joint/inverse_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/phantom_arm.h"

namespace godobject::test_inverse_kinematics {
namespace {

constexpr double half_range_m = 0.12;
constexpr double max_tilt_rad = 60 * std::numbers::pi / 180;

Pose random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Vec3 axis = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
  Pose X;
  X.p = half_range_m * Vec3(uniform(random), uniform(random), uniform(random));
  X.q = Quat(Eigen::AngleAxisd(max_tilt_rad * uniform(random), axis));
  return X;
}

TEST(InverseKinematics, WholeWorkspaceFromACommonStart) {
  const KinematicTree arm(test::phantom_arm());
  std::mt19937 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Pose X = random_pose(random);
    InverseKinematics ik(test::phantom_arm());
    const IkSolution solution = ik.solve(X);
    ASSERT_EQ(solution.status, IkStatus::solved) << "residual " << solution.residual_m << " m";
    const Pose reached = arm.at(solution.q).X_WH(0);
    EXPECT_LT((reached.p - X.p).norm(), 1e-11);
    EXPECT_LT(reached.q.angularDistance(X.q), 1e-7);  // acos near 1 resolves no better
    EXPECT_LT(solution.residual_rad, 1e-10);
  }
}

TEST(InverseKinematics, CornersOfTheWorkspace) {
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double tilt : {-max_tilt_rad, max_tilt_rad}) {
        Pose X;
        X.p = half_range_m * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        X.q = Quat(Eigen::AngleAxisd(tilt, Vec3::Unit(axis)));
        EXPECT_EQ(InverseKinematics(test::phantom_arm()).solve(X).status, IkStatus::solved)
            << "corner " << corner << " axis " << axis << " tilt " << tilt;
      }
    }
  }
}

TEST(InverseKinematics, WarmStartStaysOnOneBranchAndIsQuick) {
  InverseKinematics ik(test::phantom_arm());
  JointVector last = JointVector::Zero(6);
  for (int k = 0; k < 4000; ++k) {
    const double t = 1e-3 * k;
    Pose X;
    X.p = 0.1 * Vec3(std::sin(2 * t), std::sin(3 * t), std::sin(5 * t));
    X.q = Quat(Eigen::AngleAxisd(std::sin(4 * t), Vec3(std::cos(t), std::sin(t), 0.3).normalized()));
    const IkSolution solution = ik.solve(X);
    ASSERT_EQ(solution.status, IkStatus::solved);
    EXPECT_LE(solution.iterations, 8);
    EXPECT_LT((solution.q - last).cwiseAbs().maxCoeff(), 0.03);
    last = solution.q;
  }
}

TEST(InverseKinematics, JointRatesReproduceTheTwist) {
  const KinematicTree arm(test::phantom_arm());
  InverseKinematics ik(test::phantom_arm());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const IkSolution solution = ik.solve(random_pose(random));
    ASSERT_EQ(solution.status, IkStatus::solved);
    const Twist V{Vec3(uniform(random), uniform(random), uniform(random)),
                  Vec3(uniform(random), uniform(random), uniform(random))};
    JointVector q_dot;
    ASSERT_TRUE(ik.joint_rates(V, q_dot));
    const Twist got = arm.at(solution.q).twist(0, q_dot);
    EXPECT_LT((got.w - V.w).norm() + (got.v - V.v).norm(), 1e-9);
  }
}

TEST(InverseKinematics, UnreachablePoseIsReportedWithItsResidual) {
  InverseKinematics ik(test::phantom_arm());
  Pose X;
  X.p = Vec3(0.5, 0, 0);  // 0.92 m from the shoulder, the arm is 0.70 m long
  const IkSolution solution = ik.solve(X);
  EXPECT_EQ(solution.status, IkStatus::unreachable);
  const double distance = std::hypot(0.85, 0.35) - 0.70;
  EXPECT_NEAR(solution.residual_m, distance, 1e-3);
  EXPECT_EQ(ik.solve(Pose{}).status, IkStatus::solved);
}

TEST(InverseKinematics, GimbalLockIsSingular) {
  InverseKinematics ik(test::phantom_arm());
  JointVector q = JointVector::Zero(6);
  q(4) = std::numbers::pi / 2;
  ik.start_at(q);
  EXPECT_EQ(ik.solve(KinematicTree(test::phantom_arm()).at(q).X_WH(0)).status, IkStatus::singular);
  JointVector q_dot;
  EXPECT_FALSE(ik.joint_rates(Twist{Vec3::UnitX(), Vec3::Zero()}, q_dot));
  EXPECT_EQ(q_dot, JointVector::Zero(6));
}

TEST(InverseKinematics, RefusesAPoseThatIsNotFinite) {
  Pose X;
  X.p.x() = std::nan("");
  EXPECT_EQ(InverseKinematics(test::phantom_arm()).solve(X).status, IkStatus::wrong_input);
}

TEST(InverseKinematics, InvertsOneHandleThatAllSixJointsMoveAndSaysSo) {
  EXPECT_TRUE(InverseKinematics(test::phantom_arm()).invertible());
  const auto refuses = [](const KinematicTreeParams& device) {
    InverseKinematics ik(device);
    JointVector q_dot;
    return !ik.invertible() && ik.solve(Pose{}).status == IkStatus::wrong_input &&
           !ik.joint_rates(Twist{}, q_dot);
  };
  KinematicTreeParams five_joints = test::phantom_arm();
  five_joints.joints.pop_back();
  five_joints.handles[0].joint = "gimbal_x";
  EXPECT_TRUE(refuses(five_joints));
  KinematicTreeParams two_handles = test::phantom_arm();
  two_handles.handles.push_back({.body = "elbow", .joint = "elbow"});
  EXPECT_TRUE(refuses(two_handles));
  KinematicTreeParams branched = test::phantom_arm();
  branched.joints[5].parent = "gimbal_z";  // gimbal_x does not move the handle
  EXPECT_TRUE(refuses(branched));
}

}  // namespace
}  // namespace godobject::test_inverse_kinematics
