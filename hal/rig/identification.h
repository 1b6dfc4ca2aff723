// Mechanics of a device from slow motions of its joints under known torques. Per joint: inertia, viscous
// damping, Coulomb friction, and the weight of its link. For set-up: allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// One joint moved, the others held.
struct JointExcitation {
  std::size_t joint = 0;        // the moved joint
  double fastest_period_s = 1;  // of its motion
  std::vector<JointVector> q;   // every joint, once a period, rad or m
  std::vector<double> torque;   // torque of the drive on the joint, sent after each sample, N m or N
};

struct IdentificationParams {
  KinematicTreeParams tree;       // masses and centres of mass that are kept where no motion shows them
  Vec3 gravity_W = Vec3::Zero();  // m/s^2; zero: weights are not estimated
  double period_s = 1e-3;         // of the samples
  // from a sample to the middle of the time in which its torque acts, periods
  double torque_delay = 1.5;
};

/// An estimate and its standard error.
struct Estimate {
  double value = 0;
  double error = 0;
};

struct IdentifiedJoint {
  std::size_t joint = 0;
  Estimate inertia, damping, friction;  // as in JointPlant
  // True if the motion of this joint shows the weight of its link. Of a slider this gives the mass, of a
  // hinge the first moment of mass across the axis.
  bool has_weight = false;
  double mass = 0;           // kg
  Vec3 p_LM = Vec3::Zero();  // centre of mass, in the link's frame, m
  double weight_error = 0;   // standard error of the mass, kg, or of the moment, kg m
  double torque_rms = 0;     // of the drive, N m or N
  double residual_rms = 0;   // torque that the estimates do not explain, N m or N
};

struct Identification {
  std::vector<IdentifiedJoint> joints;  // in the order of the excitations
  std::vector<std::string> errors;      // reasons why the estimates must not be used, one line each
};

/// Returns the least-squares fit of tau = I q'' + b q' + f sign(q') - weight(q) to all excitations. Torques
/// and coordinates are smoothed alike, so that counts need no differentiation. Reversals are left out.
Identification identify(const IdentificationParams& params, const std::vector<JointExcitation>& excitations);

}  // namespace godobject
