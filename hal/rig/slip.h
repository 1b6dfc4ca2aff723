// Allowed difference between a drive's position and the encoder on its joint, before a fault is reported.
#pragma once

#include <algorithm>

#include "hal/rig/params.h"

namespace godobject {

// Slack of belts, cables and gears, unless given in the scene.
inline constexpr double hinge_slack_rad = 0.05;
inline constexpr double slider_slack_m = 0.005;
/// Counts of each sensor added to the slack, because both sensors round.
inline constexpr double slip_counts = 2;

/// Returns the allowed slip, rad or m; 0 if the two are not compared or the joint has no encoder. It is
/// max_slip, otherwise the slack for the joint's kind plus the resolution of both sensors. While the joint
/// moves, the caller adds its travel in stale_after, because a sample may legitimately be that late.
inline double allowed_slip(const RigParams& rig, const DriveParams& drive) {
  const auto encoder = std::ranges::find(rig.encoders, drive.joint, &EncoderParams::joint);
  if (encoder == rig.encoders.end()) return 0;
  if (drive.max_slip) return *drive.max_slip;
  return (is_rotary(rig, drive.joint) ? hinge_slack_rad : slider_slack_m) +
         slip_counts / encoder->calibration.counts_per_unit + slip_counts / drive.calibration.counts_per_unit;
}

}  // namespace godobject
