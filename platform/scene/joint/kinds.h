// What scene files say of the kinds of joints of core/joint/list.h, taken from the kinds themselves.
#pragma once

#include <string>
#include <vector>

#include "core/joint/list.h"

namespace godobject {

/// Names of JointKind in scene files, in its order, but for `free`: that is a body without a joint.
std::vector<std::string> joint_kind_names();

/// What joints of these kinds let the child do, in the same order.
std::string joint_kind_meanings();

inline bool is_ball(JointKind kind) noexcept { return num_axes(kind).turns == 3; }

/// Coordinates that have a name: a ball joint's turns have none.
inline std::size_t num_coordinates(JointKind kind) noexcept {
  const NumAxes n = num_axes(kind);
  return is_ball(kind) ? 0 : static_cast<std::size_t>(n.turns + n.slides);
}

/// Whether coordinate i of the joint is a turn, rad; otherwise it is a slide, m.
inline bool is_turn(JointKind kind, std::size_t i) noexcept {
  return i < static_cast<std::size_t>(num_axes(kind).turns);
}

/// Unit axis of coordinate i where all are zero, in the frame that both bodies then share.
Vec3 axis_at_zero(JointKind kind, std::size_t i) noexcept;

/// All its axes, if any have a name, are the frames' z.
bool is_along_z(JointKind kind) noexcept;

/// Names for coordinates that have none.
std::vector<std::string> default_coordinates(const std::string& joint, JointKind kind);

/// Angle between the frames that the joint does not allow, rad.
double angular_gap(JointKind kind, const JointFrames& X) noexcept;

}  // namespace godobject
