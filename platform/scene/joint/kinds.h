// Properties of the kinds of joints for scene files, derived from core/joint/list.h.
#pragma once

#include <string>
#include <vector>

#include "core/joint/list.h"

namespace godobject {

/// Returns the names of JointKind in scene files, in its order, without `free`, which is a body without a
/// joint.
std::vector<std::string> joint_kind_names();

/// Returns the motions that joints of these kinds allow, in the same order.
std::string joint_kind_meanings();

inline bool is_ball(JointKind kind) noexcept { return num_axes(kind).turns == 3; }

/// Returns the number of named coordinates; the turns of a ball joint have no names.
inline std::size_t num_coordinates(JointKind kind) noexcept {
  const NumAxes n = num_axes(kind);
  return is_ball(kind) ? 0 : static_cast<std::size_t>(n.turns + n.slides);
}

/// True if coordinate i is a turn, rad; a slide, m, otherwise.
inline bool is_turn(JointKind kind, std::size_t i) noexcept {
  return i < static_cast<std::size_t>(num_axes(kind).turns);
}

/// Returns the unit axis of coordinate i, in the common frame of both bodies at coordinates zero.
Vec3 axis_at_zero(JointKind kind, std::size_t i) noexcept;

/// True if the axes of all named coordinates are the frames' z, or if there are none.
bool is_along_z(JointKind kind) noexcept;

/// Returns default names of the coordinates.
std::vector<std::string> default_coordinates(const std::string& joint, JointKind kind);

/// Returns the angle between the frames that violates the joint, rad.
double angular_gap(JointKind kind, const JointFrames& X) noexcept;

}  // namespace godobject
