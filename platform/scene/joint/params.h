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
/// Up to this a gap is rounding.
inline constexpr JointGap rounded_gap{.m = 1e-6, .rad = 1e-6};
inline bool is_apart(const JointGap& gap) noexcept {
  return !(gap.m <= rounded_gap.m && gap.rad <= rounded_gap.rad);
}
/// Moves each child whose joint is apart to where the joint holds, and its own children with it. Coordinates
/// stay as they are. bodies: parents first.
void close_gaps(std::span<BodyConfig> bodies, std::span<const JointConfig> joints);
/// Coordinates of the joint there; zero for a kind without.
JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);

}  // namespace godobject
