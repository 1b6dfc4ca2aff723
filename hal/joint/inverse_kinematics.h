// Joint coordinates of a six-joint arm from the pose of its one handle: how a motion that is given as
// a pose is played through joint encoders.
#pragma once

#include "hal/joint/kinematic_tree.h"

namespace godobject {

enum class IkStatus : std::uint8_t {
  solved,
  singular,     // pose met, but no joint rates give an arbitrary twist there
  unreachable,  // no convergence: outside the workspace, or not reached from this start
  wrong_input,  // not a device this can invert, or a pose that is not finite
};

struct IkSolution {
  JointVector q;  // best found, also when not solved
  IkStatus status = IkStatus::wrong_input;
  double residual_m = 0;    // distance of the handle from the wanted position
  double residual_rad = 0;  // angle from the wanted attitude
  int iterations = 0;
};

/// Levenberg-damped Newton on the pose error. Stateful: each solve starts from the last solution, so
/// a continuous motion stays on one branch. Bounded work, no heap.
class InverseKinematics {
 public:
  explicit InverseKinematics(const KinematicTreeParams& tree) noexcept;

  /// Whether the device is of the kind this can invert: one handle, and six joints all of which move it.
  bool invertible() const noexcept;

  /// Starting point of the next solve. The device's own q = 0 at construction.
  void start_at(const JointVector& q) noexcept { q_ = q; }

  /// On `unreachable` the starting point is kept as it was.
  IkSolution solve(const Pose& X_WH) noexcept;

  /// q_dot with J(q) q_dot = V_WH, at the last solution. False (and q_dot = 0) where J is singular.
  [[nodiscard]] bool joint_rates(const Twist& V_WH, JointVector& q_dot) const noexcept;

 private:
  KinematicTree tree_;
  JointVector q_;
};

}  // namespace godobject
