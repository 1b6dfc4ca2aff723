// How far a drive's position may part from the encoder on its joint before one of them is taken for wrong.
#pragma once

#include <algorithm>

#include "hal/rig/params.h"

namespace godobject {

// The slack of belts, cables and gears where the scene does not say.
inline constexpr double hinge_slack_rad = 0.05;
inline constexpr double slider_slack_m = 0.005;
/// Counts of each sensor that a slip may be: it rounds, and so does what it is compared with.
inline constexpr double slip_counts = 2;

/// rad or m; 0: the two are not compared, or the joint has no encoder. max_slip, else the slack of the joint's kind and
/// what the two sensors cannot tell apart. While the joint moves its travel in stale_after comes on top: a sample may
/// be that late without being a fault.
inline double allowed_slip(const RigParams& rig, const DriveParams& drive) {
  const auto encoder = std::ranges::find(rig.encoders, drive.joint, &EncoderParams::joint);
  if (encoder == rig.encoders.end()) return 0;
  if (drive.max_slip) return *drive.max_slip;
  const auto joint = std::ranges::find(rig.tree.joints, drive.joint, &DeviceJoint::name);
  const bool hinge = joint == rig.tree.joints.end() || joint->kind == DeviceJointKind::hinge;
  return (hinge ? hinge_slack_rad : slider_slack_m) + slip_counts / encoder->calibration.counts_per_unit +
         slip_counts / drive.calibration.counts_per_unit;
}

}  // namespace godobject
