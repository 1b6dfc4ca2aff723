// Mechanics of a simulated device: the joints of its encoders and drives, and the hand that holds it.
#pragma once

#include <vector>

#include "hal/can/frame.h"
#include "hal/joint/kinematic_tree.h"
#include "hal/rig/simulation.h"

namespace godobject {

/// Joints are independent (no coupling inertia):
///   I q'' = tau_motor - b q' - f_c sign(q') + k_h (q_ref - q) + d_h (q_ref' - q')
/// with JointPlant's inertia I, damping b, friction f_c and the hand's k_h, d_h. Implicit Euler with a fixed
/// sub-step in every term. Friction is the set-valued law, exact below breakaway. Stable for all non-negative
/// parameters. A device without haptics follows the reference exactly.
class SimPlant {
 public:
  static constexpr Nanoseconds substep_ns = 50'000;

  /// joints: at most max_joints. haptic: the device has a hand, mass and motors. q0, t_ns: configuration and
  /// time at which it starts at rest.
  SimPlant(std::vector<JointPlant> joints, bool haptic, const JointVector& q0, Nanoseconds t_ns);
  /// As above, with equal joints.
  SimPlant(const JointPlant& each, std::size_t num_joints, bool haptic, const JointVector& q0,
           Nanoseconds t_ns);

  /// Sets the motor torque on a joint, after the transmission (N m or N); held until set again.
  void set_motor_torque(std::size_t joint, double tau) noexcept;

  /// Advances to t_ns in whole sub-steps; the remainder is carried over. q_ref, q_ref_dot: reference of the
  /// hand for the joints at t_ns and its rate.
  void advance(Nanoseconds t_ns, const JointVector& q_ref, const JointVector& q_ref_dot) noexcept;

  const JointVector& q() const noexcept { return q_; }
  const JointVector& q_dot() const noexcept { return q_dot_; }
  /// Returns the torque of the hand on each joint in the last sub-step; zero without haptics.
  const JointVector& hand_torque() const noexcept { return tau_hand_; }

 private:
  void substep(Eigen::Index joint, double q_ref, double q_ref_dot) noexcept;

  std::vector<JointPlant> joints_;
  bool haptic_;
  Nanoseconds t_ns_;
  JointVector q_, q_dot_, tau_motor_, tau_hand_;
};

}  // namespace godobject
