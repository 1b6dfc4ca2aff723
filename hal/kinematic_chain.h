// The device's serial kinematic chain: from joint coordinates to the handle and back.
#pragma once

#include <array>
#include <cstddef>

#include "core/types.h"
#include "hal/rig_params.h"

namespace godobject {

inline constexpr std::size_t max_joints = 8;

/// One number per joint, from the base outwards (rad or m, their rates, N m or N). Lives on the stack.
using JointVector = Eigen::Matrix<Real, Eigen::Dynamic, 1, Eigen::ColMajor, static_cast<int>(max_joints), 1>;
/// 6 x n: V_WH = J q_dot, rows angular first. Lives on the stack.
using ChainJacobian =
    Eigen::Matrix<Real, 6, Eigen::Dynamic, Eigen::ColMajor, 6, static_cast<int>(max_joints)>;

/// The chain at one configuration: everything the loop needs of it.
struct ChainConfiguration {
  Pose X_WH;        // handle in the world
  ChainJacobian J;  // geometric Jacobian of the handle origin, world axes

  /// V_WH = J q_dot: world axes, angular first, velocity of the handle origin.
  Twist twist(const JointVector& q_dot) const noexcept;
  /// tau = J^T F for a wrench on the handle, world axes, about the handle origin.
  JointVector joint_torques(const Wrench& F_H_W) const noexcept;
};

class KinematicChain {
 public:
  /// chain: at most max_joints joints with unit axes (see Rig's validation); the rest is ignored.
  explicit KinematicChain(const ChainParams& chain) noexcept;

  std::size_t num_joints() const noexcept { return num_joints_; }
  /// q: num_joints() numbers.
  ChainConfiguration at(const JointVector& q) const noexcept;

 private:
  struct Joint {
    ChainJointKind kind = ChainJointKind::hinge;
    Pose X_PJ;
    Vec3 axis_J = Vec3::UnitZ();
  };

  Pose X_WB_;
  std::array<Joint, max_joints> joints_{};
  std::size_t num_joints_ = 0;
  Pose X_LH_;
};

}  // namespace godobject
