// Torques of the drives for the device itself: they carry its weight, overcome its friction, move its mass.
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
  std::vector<double> inertia{};        // moved by the drives, kg m^2 or kg; below the joint's own
  double inertia_cutoff = 1;            // of the acceleration that they follow, rad/s, > 0
  double ahead_s = 0;                   // handles are predicted over this time, s, >= 0
};

/// Returns the inertia of a joint that its drive moves, kg m^2 or kg.
inline double carried_inertia(const CompensationParams& params, std::size_t joint) noexcept {
  return joint < params.inertia.size() ? params.inertia[joint] : 0;
}

/// Returns the torques of the joints for weight and friction, N m or N. at: the device's configuration.
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
