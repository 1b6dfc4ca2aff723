// The mechanics of a simulated device: what its encoders and drives sit on, and the hand that holds it.
#pragma once

#include <vector>

#include "hal/can/frame.h"
#include "hal/joint/kinematic_tree.h"
#include "hal/rig/simulation.h"

namespace godobject {

/// Joints are taken one by one (no coupling inertia):
///   I q'' = tau_motor - b q' - f_c sign(q') + k_h (q_ref - q) + d_h (q_ref' - q')
/// with JointPlant's inertia I, damping b, friction f_c and the hand's k_h, d_h. Implicit Euler with a
/// fixed sub-step in every term, friction as the set-valued law (it holds exactly below breakaway):
/// stable for all non-negative parameters. A device without haptics follows the reference exactly.
class SimPlant {
 public:
  static constexpr Nanoseconds substep_ns = 50'000;

  /// joints: at most max_joints. haptic: the device has a hand, mass and motors. The plant rests
  /// at q0 at t_ns.
  SimPlant(std::vector<JointPlant> joints, bool haptic, const JointVector& q0, Nanoseconds t_ns);
  /// All joints alike.
  SimPlant(const JointPlant& each, std::size_t num_joints, bool haptic, const JointVector& q0,
           Nanoseconds t_ns);

  /// Motor torque on the joint, after the transmission (N m or N); holds until set again.
  void set_motor_torque(std::size_t joint, double tau) noexcept;

  /// Moves to t_ns in whole sub-steps (the rest is carried over). The reference is where the hand wants
  /// the joints at t_ns and how fast it moves there.
  void advance(Nanoseconds t_ns, const JointVector& q_ref, const JointVector& q_ref_dot) noexcept;

  const JointVector& q() const noexcept { return q_; }
  const JointVector& q_dot() const noexcept { return q_dot_; }
  /// Torque of the hand on each joint in the last sub-step; zero without haptics.
  const JointVector& hand_torque() const noexcept { return tau_hand_; }

 private:
  void substep(Eigen::Index joint, double q_ref, double q_ref_dot) noexcept;

  std::vector<JointPlant> joints_;
  bool haptic_;
  Nanoseconds t_ns_;
  JointVector q_, q_dot_, tau_motor_, tau_hand_;
};

}  // namespace godobject
