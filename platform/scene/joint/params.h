// Conversion of a scene's joints into parameters of the core, and their state at the start.
#pragma once

#include <span>

#include "platform/scene/scene.h"

namespace godobject {

/// Converts a joint. Its parent is the index in `bodies`, which lists the parent before the child.
JointParams joint_params(std::span<const BodyConfig> bodies, const JointConfig& joint);

/// Violation of a joint: distance and angle between its frames.
struct JointGap {
  double m = 0;
  double rad = 0;
};

/// Returns the violation with the bodies at their places in the scene. Both bodies exist, in any order.
JointGap gap_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);
/// Largest violation explained by rounding.
inline constexpr JointGap rounded_gap{.m = 1e-6, .rad = 1e-6};
inline bool is_apart(const JointGap& gap) noexcept {
  return !(gap.m <= rounded_gap.m && gap.rad <= rounded_gap.rad);
}
/// Moves each child with a violated joint to satisfy it, together with its own children. Coordinates do not
/// change. bodies: parents first.
void close_gaps(std::span<BodyConfig> bodies, std::span<const JointConfig> joints);
/// Returns the coordinates of the joint at the start; zero for a kind without coordinates.
JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);

}  // namespace godobject
