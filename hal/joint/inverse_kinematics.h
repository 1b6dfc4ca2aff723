// Joint coordinates of a six-joint arm from the pose of its only handle. Used to play a motion given as poses
// through joint encoders.
#pragma once

#include "hal/joint/kinematic_tree.h"

namespace godobject {

enum class IkStatus : std::uint8_t {
  solved,
  singular,     // the pose is reached, but J cannot give an arbitrary twist there
  unreachable,  // no convergence: outside the workspace, or not reachable from this start
  wrong_input,  // device not invertible, or a pose that is not finite
};

struct IkSolution {
  JointVector q;  // best estimate, also if not solved
  IkStatus status = IkStatus::wrong_input;
  double residual_m = 0;    // distance of the handle from the requested position
  double residual_rad = 0;  // angle from the requested attitude
  int iterations = 0;
};

/// Levenberg-damped Newton iteration on the pose error. Stateful: each solve starts from the last solution,
/// so a continuous motion stays on one branch. Bounded work, no heap.
class InverseKinematics {
 public:
  explicit InverseKinematics(const KinematicTreeParams& tree) noexcept;

  /// True if the device can be inverted: one handle, and six joints that all move it.
  bool invertible() const noexcept;

  /// Sets the starting point of the next solve. Default: q = 0.
  void start_at(const JointVector& q) noexcept { q_ = q; }

  /// Solves for q. Keeps the starting point if `unreachable`.
  IkSolution solve(const Pose& X_WH) noexcept;

  /// Computes q_dot with J(q) q_dot = V_WH at the last solution. Returns false and q_dot = 0 if J is
  /// singular.
  [[nodiscard]] bool joint_rates(const Twist& V_WH, JointVector& q_dot) const noexcept;

 private:
  KinematicTree tree_;
  JointVector q_;
};

}  // namespace godobject
