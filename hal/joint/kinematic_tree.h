// Kinematic tree of the device: maps joint coordinates to handles and wrenches to joint torques.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/math/types.h"
#include "hal/joint/params.h"

namespace godobject {

inline constexpr std::size_t max_joints = 16;
inline constexpr std::size_t max_handles = 8;

/// One number per joint, in the order of the parameters (rad or m, their rates, N m or N). Stored in place.
using JointVector = Eigen::Matrix<Real, Eigen::Dynamic, 1, Eigen::ColMajor, static_cast<int>(max_joints), 1>;
/// 6 x n: V_WH = J q_dot, angular rows first. Stored in place.
using HandleJacobian =
    Eigen::Matrix<Real, 6, Eigen::Dynamic, Eigen::ColMajor, 6, static_cast<int>(max_joints)>;

/// Joint coordinates of the device and their rates.
struct JointTarget {
  JointVector q;
  JointVector q_dot;
};

/// Returns the parent link of joint `index`: 0 is the base, k + 1 the link of joint k. Returns nullopt if the
/// parent is no earlier joint.
std::optional<std::size_t> parent_link(std::span<const DeviceJoint> joints, std::size_t index) noexcept;

/// The tree at one configuration. Handles and joints are indexed as in the parameters. World axes throughout;
/// twists and wrenches refer to the handle's origin.
class TreeConfiguration {
 public:
  std::size_t num_joints() const noexcept { return num_joints_; }
  std::size_t num_handles() const noexcept { return num_handles_; }

  const Pose& X_WH(std::size_t handle) const noexcept { return handles_[handle].X_WH; }
  /// Returns the geometric Jacobian; the column of a joint that does not move the handle is zero.
  HandleJacobian jacobian(std::size_t handle) const noexcept;
  /// Returns V_WH = J q_dot.
  Twist twist(std::size_t handle, const JointVector& q_dot) const noexcept;
  /// Returns tau = sum over the handles of J^T F: the wrenches of (8), shifted to the parents by (9) and
  /// projected on the joint axes. F_H_W: one per handle; missing ones are zero, surplus ones are ignored.
  JointVector joint_torques(std::span<const Wrench> F_H_W) const noexcept;
  /// Returns the torques of the links' weight on the joints, the negative gradient of
  /// U = - sum m g . p_WM. g_W: gravity, m/s^2.
  JointVector weight_torques(const Vec3& g_W) const noexcept;

 private:
  friend class KinematicTree;
  struct Joint {
    Vec3 axis_W = Vec3::Zero();
    Vec3 p_WJ = Vec3::Zero();
    bool hinge = true;
    double mass = 0;           // of the link and all links that it carries, kg
    Vec3 mp_W = Vec3::Zero();  // their first moment of mass about the world's origin, kg m
  };
  struct Handle {
    Pose X_WH;
    std::uint32_t movers = 0;  // bit j: joint j moves the handle
  };

  bool moves(std::size_t joint, std::size_t handle) const noexcept {
    return (handles_[handle].movers >> joint & 1u) != 0;
  }
  Twist column(std::size_t handle, std::size_t joint) const noexcept;

  std::array<Joint, max_joints> joints_{};
  std::array<Handle, max_handles> handles_{};
  std::size_t num_joints_ = 0, num_handles_ = 0;
};

class KinematicTree {
 public:
  /// tree: valid by Rig's validation. Joints and handles beyond the capacities are ignored; an invalid parent
  /// is replaced by the base.
  explicit KinematicTree(const KinematicTreeParams& tree) noexcept;

  std::size_t num_joints() const noexcept { return num_joints_; }
  std::size_t num_handles() const noexcept { return num_handles_; }
  /// True if the handle depends on the joint's coordinate.
  bool moves(std::size_t joint, std::size_t handle) const noexcept {
    return (handles_[handle].movers >> joint & 1u) != 0;
  }
  /// Returns the tree at a configuration. q: num_joints() coordinates, rad or m.
  TreeConfiguration at(const JointVector& q) const noexcept;

 private:
  struct Joint {
    DeviceJointKind kind = DeviceJointKind::hinge;
    std::size_t parent_link = 0;  // numbered as by parent_link()
    Pose X_PJ;
    Vec3 axis_J = Vec3::UnitZ();
    double mass = 0;
    Vec3 p_LM = Vec3::Zero();
  };
  struct Handle {
    std::size_t link = 0;
    Pose X_LH;
    std::uint32_t movers = 0;
  };

  Pose X_WB_;
  std::array<Joint, max_joints> joints_{};
  std::array<Handle, max_handles> handles_{};
  std::size_t num_joints_ = 0, num_handles_ = 0;
};

}  // namespace godobject
