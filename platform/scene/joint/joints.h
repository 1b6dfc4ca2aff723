// Joints of a scene: properties of their kinds, parameters for core, their tree, and the implied device.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/joint/list.h"
#include "hal/rig/params.h"
#include "platform/scene/scene.h"

namespace godobject {

// Properties of the kinds of joints, derived from core/joint/list.h.

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

// Parameters for core, and the state at the start.

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
/// Places the children of joints with coordinates `start`, if they have no place of their own, and the bodies
/// joined to them. bodies: parents first.
void place_children(std::span<BodyConfig> bodies, std::span<const JointConfig> joints);
/// Returns the coordinates of the joint at the start, in the turn of its key `start`, else between its stops.
/// Zero for a kind without coordinates.
JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint);

/// Motions that joints, closing joints and rigid gears leave to the bodies at their places, to first order.
struct Mobility {
  std::size_t num_freedoms = 0;
  std::size_t num_constraints = 0;  // of closing joints and rigid gears
  std::size_t num_redundant = 0;    // of them, implied by the others; their forces are shared
};
Mobility mobility_at_start(const SceneConfig& scene);

// Joints as edges between bodies.

/// Adds joints one by one, each checked against the earlier ones.
class JointTree {
 public:
  struct Added {
    std::string why_not{};            // why the joint cannot be added, with the remedy; empty on success
    std::vector<std::string> loop{};  // earlier joints with which it closes a loop; it is no part of the tree
  };
  /// Adds a joint whose bodies exist.
  Added add(const JointConfig& joint);

 private:
  struct Edge {
    std::string name, parent, child;
  };

  /// Returns the names of the joints on the path between two bodies, or a body and the world; none if they
  /// are not connected.
  std::optional<std::vector<std::string>> way(const std::string& from, const std::string& to) const;
  bool extend_way(const std::string& from, const std::string& to, std::vector<std::string>& joints) const;

  std::vector<Edge> edges_;
};

/// True if the bodies of the joint exist.
inline bool has_bodies(const SceneConfig& scene, const JointConfig& joint) {
  return body_named(scene, joint.child) && (joint.parent == world_name || body_named(scene, joint.parent));
}

/// True if the bodies of every joint exist. Otherwise an error at the joint names the missing body, and
/// checks of pairs of bodies are left out.
inline bool joints_have_bodies(const SceneConfig& scene) {
  return std::ranges::all_of(scene.joints,
                             [&](const JointConfig& joint) { return has_bodies(scene, joint); });
}

/// Returns the bodies with every parent before its children, otherwise in their order. joints: a tree.
std::vector<BodyConfig> parents_first(const std::vector<BodyConfig>& bodies,
                                      const std::vector<JointConfig>& joints);

// A device with the kinematics of the virtual instrument, whose joints are those of the scene.

struct DeviceTree {
  KinematicTreeParams tree;
  std::vector<std::string> errors;  // reasons why there is no such device; if any, the tree is incomplete
};

/// Makes a hinge or slider for each named coordinate, with its name, and a handle at the frame of each
/// coupled body. At coordinates q the handles have the poses of the instrument's bodies. Bodies: parents
/// first.
DeviceTree device_from_joints(const SceneConfig& scene);

}  // namespace godobject
