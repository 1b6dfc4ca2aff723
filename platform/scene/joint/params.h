// A scene's joints in the core's terms, and how they stand at the start.
#pragma once

#include <span>

#include "platform/scene/scene.h"

namespace godobject {

/// The joint for the core; parent: as the bodies are counted, which has it before the child.
JointParams joint_params(std::span<const BodyConfig> bodies, const JointConfig& joint);

/// How far the frames of a joint are from where it lets them be.
struct JointGap {
  double m = 0;
  double rad = 0;
};

/// The gap between the bodies as the scene places them. Both bodies exist; they may stand in any order.
JointGap gap_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);
/// Coordinates of the joint there; zero for a kind without.
JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);

}  // namespace godobject
