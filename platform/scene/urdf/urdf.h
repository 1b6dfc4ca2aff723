// Robot descriptions in URDF, converted to scene files. reader.cc reads XML, scene.cc writes the scene.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/types.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {

enum class UrdfShapeKind : std::uint8_t { box, sphere, cylinder, mesh };

/// A collision shape. Each kind uses only its dimensions.
struct UrdfShape {
  TextPosition at;
  UrdfShapeKind kind = UrdfShapeKind::box;
  Pose X_L;                  // shape's frame on the link
  Vec3 size = Vec3::Ones();  // box: edges, m, > 0; mesh: scale of each axis, > 0
  double radius = 0;         // sphere, cylinder: m, > 0
  double length = 0;         // cylinder: along z, m, > 0
  std::string file;          // mesh: name as in the description
};

struct UrdfInertial {
  double mass = 0;          // kg, > 0
  Vec3 p_L = Vec3::Zero();  // centre of mass, m, link axes
  Mat3 I_L = Mat3::Zero();  // kg m^2 about the centre of mass, link axes, positive definite
};

struct UrdfLink {
  TextPosition at;
  std::string name;
  std::optional<UrdfInertial> inertial;
  std::vector<UrdfShape> shapes;
};

/// Kinds of joints in descriptions, in the order of urdf_joint_kinds.
enum class UrdfJointKind : std::uint8_t { revolute, continuous, prismatic, fixed, floating };
inline constexpr std::array<std::string_view, 5> urdf_joint_kinds{"revolute", "continuous", "prismatic",
                                                                  "fixed", "floating"};

/// Stops of a joint.
struct UrdfLimit {
  double lower = 0, upper = 0;  // rad or m, lower < upper
  double effort = 0;            // N m or N, > 0
};

/// Width of a joint's stops, as a share of its range.
inline constexpr double stop_width = 0.01;

/// Coordinate that follows another joint's: multiplier times it, plus offset.
struct UrdfMimic {
  TextPosition at;
  std::string joint;
  double multiplier = 1, offset = 0;
};

struct UrdfJoint {
  TextPosition at;
  std::string name;
  UrdfJointKind kind = UrdfJointKind::fixed;
  std::string parent, child;       // names of links
  Pose X_PC;                       // child's frame on the parent's, at coordinate zero
  Vec3 axis_C = Vec3::UnitX();     // unit vector in the child's frame
  std::optional<UrdfLimit> limit;  // of revolute and prismatic joints
  std::optional<UrdfMimic> mimic;
  bool moves() const { return kind != UrdfJointKind::fixed && kind != UrdfJointKind::floating; }
};

struct UrdfRobot {
  std::string name;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
  std::map<std::string, int> left_out;  // numbers of elements that scenes cannot express
};

/// Reads a description and checks each element by itself; all errors and warnings are added to `log`.
/// Returns none if the text is not a description at all.
std::optional<UrdfRobot> read_urdf(std::string_view xml, Diagnostics& log);

/// Index of the group of links that are the world.
inline constexpr std::size_t urdf_ground = 0;

/// A link of a group.
struct UrdfPart {
  const UrdfLink* link = nullptr;
  const UrdfJoint* joint = nullptr;  // whose child it is; null: the root
  Pose X;                            // link's frame on the group
};

/// Links without motion between them: a body, or the world.
struct UrdfGroup {
  const UrdfLink* first = nullptr;   // its frame is that of the group
  const UrdfJoint* joint = nullptr;  // from the parent; null: of the root
  std::size_t parent = urdf_ground;  // index of the parent's group
  std::size_t tool = urdf_ground;    // first group of those that are joined other than through the world
  Pose X_P;                          // its frame on the parent's, at coordinate zero
  Pose X_W;                          // its frame in the world at the start
  double start = 0;                  // coordinate of the joint at the start, rad or m
  double mass = 0;                   // kg
  Vec3 c = Vec3::Zero();             // centre of mass, m, in its frame
  Mat3 I = Mat3::Zero();             // kg m^2 about the centre of mass
  std::vector<UrdfPart> links;       // `first`, and those merged into it
};

/// Returns the groups of a robot, parents first and links in the order of the file; the first is the world.
/// All errors of the tree are added to `log`. A link on a fixed joint is in the group of its parent. On the
/// world it is a body if it has mass. Joints start at zero, or at their limit nearest to it. Those that
/// follow another joint start where that one puts them.
std::vector<UrdfGroup> groups_of(const UrdfRobot& robot, Diagnostics& log);

/// Returns the robot as a scene file; shapes that are left out are warnings in `log`.
/// scene_folder: folder of the scene, from which the files of meshes are named.
std::string scene_of_urdf(const UrdfRobot& robot, const std::vector<UrdfGroup>& groups,
                          const std::string& scene_folder, Diagnostics& log);

}  // namespace godobject
