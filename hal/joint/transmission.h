// Transmission between actuators and joints. Cables over discs couple joints: a disc moves several of them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// A group of joints moved by as many actuators, q = M a. The drive, or encoder, that names the i-th joint of
/// the group is on its i-th actuator.
struct TransmissionParams {
  std::vector<std::string> joints;  // rows of M
  // M by rows, invertible: rad or m of a joint per rad of an actuator
  std::vector<std::vector<double>> joint_per_actuator{};
};

/// Returns the errors of the transmissions of a tree, one sentence each: sizes, joints, singular matrices.
std::vector<std::string> validate(std::span<const TransmissionParams> transmissions,
                                  std::span<const DeviceJoint> joints);

/// Maps coordinates and torques of all joints of a device. Joints outside of every group have actuators of
/// their own: q_i = a_i.
class Transmission {
 public:
  Transmission() = default;
  /// transmissions: valid. joints: those of the device. Allocates; no other function does.
  Transmission(std::span<const TransmissionParams> transmissions, std::span<const DeviceJoint> joints);

  /// Returns q = M a, also for velocities.
  JointVector joints(const JointVector& a) const noexcept { return product(M_, a); }
  /// Returns a = M^-1 q, also for velocities.
  JointVector actuators(const JointVector& q) const noexcept { return product(M_inverse_, q); }
  /// Returns the actuators' torques M^T tau: power is conserved, tau_a . a' = tau . q'.
  JointVector actuator_torques(const JointVector& tau) const noexcept { return product(M_transposed_, tau); }
  /// Returns the joints' torques M^-T tau_a.
  JointVector joint_torques(const JointVector& tau_a) const noexcept {
    return product(M_inverse_transposed_, tau_a);
  }
  /// Returns M^T A M, a stiffness, damping or inertia of the joints at the actuators.
  Eigen::MatrixXd at_actuators(const Eigen::MatrixXd& A) const;

 private:
  using JointMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                    static_cast<int>(max_joints), static_cast<int>(max_joints)>;
  static JointVector product(const JointMatrix& A, const JointVector& x) noexcept;

  JointMatrix M_, M_transposed_, M_inverse_, M_inverse_transposed_;  // empty: the identity
};

}  // namespace godobject
