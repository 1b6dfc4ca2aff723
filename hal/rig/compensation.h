// Torques of the drives for the device itself: they carry its weight and overcome its friction.
#pragma once

#include <algorithm>

#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// All zero: no compensation.
struct CompensationParams {
  Vec3 gravity_W = Vec3::Zero();  // gravity on the links whose weight the drives carry, m/s^2
  // By joint; missing ones are zero:
  std::vector<double> friction{};       // torque along the motion, N m or N; at most the joint's own friction
  std::vector<double> certain_speed{};  // speed from which all of it acts, rad/s or m/s, > 0
  double ahead_s = 0;                   // handles are predicted over this time, s, >= 0
};

/// Returns the compensating torques of the joints, N m or N. at: the device's configuration.
///
/// Friction f of the device removes the power f |q'|, and its compensation adds no more than its share of f,
/// |q'| times. So the pair dissipates, however late or wrong the measured q' is.
inline JointVector compensating_torques(const CompensationParams& params, const TreeConfiguration& at,
                                        const JointVector& q_dot) noexcept {
  JointVector tau = -at.weight_torques(params.gravity_W);
  for (std::size_t j = 0; j < std::min(at.num_joints(), params.friction.size()); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    tau(i) += params.friction[j] * std::clamp(q_dot(i) / params.certain_speed[j], -1.0, 1.0);
  }
  return tau;
}

}  // namespace godobject
