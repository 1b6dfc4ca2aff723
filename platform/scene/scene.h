// A scene as described by its file: plain values, SI, validated. platform/scene/toml.cc fills it;
// platform/engine/engine.cc selects a compiled composition of the core for it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/body/coupling.h"
#include "core/joint/list.h"
#include "core/joint/stops.h"
#include "core/net/net.h"
#include "hal/rig/params.h"
#include "hal/rig/simulation.h"
#include "hal/tracker/params.h"
#include "platform/scene/geometry.h"

namespace godobject {

/// Bounds of the displayed wrench, and the ramp on engaging.
struct LimitConfig {
  double force = 10;        // N
  double torque = 0.5;      // N m
  double force_rate = 500;  // N/s
  double torque_rate = 25;  // N m/s
  double ramp = 0.5;        // s, from engaging to full coupling and feedback; 0: at once
  double grab_ramp = 0.05;  // s, from gripping a body to full coupling and feedback
};

/// Names of DeviceKind in scene files, in its order.
inline constexpr std::array device_kind_names{"impedance", "non-haptic", "admittance", "relative"};

/// Names of the integrators in scene files and --integrator.
inline constexpr std::array integrator_names{"implicit-euler", "tr-bdf2"};

enum class DeviceKind : std::uint8_t {
  impedance,   // pose in, force out
  non_haptic,  // pose in, nothing out
  admittance,  // force in, pose out
  relative,    // increments in through a clutch
};

/// Name of the body nearest to the device in scene files and motions. No body that can be held has this name.
inline constexpr const char* nearest_body = "nearest";

/// From this time on the device holds the named body, nearest_body, or nothing.
struct HoldConfig {
  double time = 0;   // s
  std::string body;  // empty: releases the held body
};

/// A SpaceMouse connected by spacenavd: the deflection of its cap sets the velocity of the target.
struct SpaceMouseConfig {
  std::string body;              // name of the coupled body that it moves
  Quat q_WM = Quat::Identity();  // its frame in the world: x to the right, y away from the user, z up
  double max_speed = 0.1;        // m/s, at full scale
  double max_turn_rate = 1;      // rad/s, at full scale
  double full_scale = 350, deadband = 10;  // counts
  double rate_hz = 60;                     // rate of reports while it is pushed
  int clutch_button = 0, hold_button = 1;  // -1: none
};

/// Compensation of the device's own mechanics by its drives.
struct CompensationConfig {
  bool gravity = false;          // they carry its links
  double friction = 0;           // share of its Coulomb friction that they overcome, 0 to 1
  double inertia = 0;            // share of its inertia that they move, 0 to max_inertia_share
  double inertia_cutoff_Hz = 5;  // up to which they do
  double ahead_s = 0;            // time over which the handles are predicted, s
  static constexpr double max_inertia_share = 0.9;
};

struct DeviceConfig {
  std::string name;
  DeviceKind kind = DeviceKind::impedance;
  double display_ratio = 1;             // shift of a relative device's target for a shift of the device
  bool controls_passivity = true;       // each drive without margin has a passivity controller
  std::string holds{};                  // name of the body held at the start; empty: none
  std::optional<double> grab_radius{};  // m, reach of nearest_body, from the device to a centre of mass
  LimitConfig limits;
  std::optional<RigParams> rig;                          // absent: the scene runs only with --bus direct
  std::optional<KinematicTreeParams> unmeasured_tree{};  // without a rig: joints moved by a motion alone
  PlantConfig plant;
  CompensationConfig compensation{};
  std::vector<TrackerParams> trackers{};
  std::optional<SpaceMouseConfig> spacemouse{};
};

struct BodyConfig {
  std::string name;
  double mass = 1;                       // kg, > 0
  Mat3 inertia = Mat3::Identity();       // kg m^2 about the centre of mass, body axes, positive definite
  Pose X_WB;                             // pose at t = 0
  bool is_placed = false;                // true if the file gives the pose; otherwise joints may
  Twist V_WB;                            // velocity at t = 0
  std::optional<SpringParams> coupling;  // spring to the target (2); absent: free
  std::optional<SpringParams> feedback;  // spring of the displayed wrench (8); absent or zero: no haptics
  std::vector<SphereConfig> spheres{};   // touch solids outside of its own tool
  std::vector<ShapeConfig> shapes{};     // touched by spheres of other bodies; without shapes its spheres are
};

/// Name of the ground in joints and messages. No body has this name.
inline constexpr const char* world_name = "world";

/// Springs at the ends of one coordinate of a joint (19).
struct StopConfig {
  std::string coordinate;  // name of the joint's coordinate
  StopParams params{};     // an infinite end has no stop
};

/// Spring on one coordinate of a joint.
struct JointSpringConfig {
  std::string coordinate;  // name of the joint's coordinate
  double k = 0;            // N m/rad or N/m
  double g = 0;            // N m s/rad or N s/m
  double rest = 0;         // rad or m
};

struct JointConfig {
  std::string name;
  JointKind kind = JointKind::hinge;
  std::string parent = world_name;  // name of a body, or world_name
  std::string child;                // name of a body
  Pose X_BP;  // joint frame on the parent, in body axes about its centre of mass; on the world in the world
  Pose X_BC;  // joint frame on the child, in body axes about its centre of mass
  std::vector<std::string> coordinates;  // num_coordinates(kind) names: turns, then slides
  bool prescribed = false;               // true: the device's joints of the same names move the coordinates
  std::vector<StopConfig> stops;         // at most one for each coordinate
  std::vector<JointSpringConfig> springs{};
  // coordinates at t = 0, rad or m, which place the child; empty: those of the bodies' poses
  std::array<std::optional<double>, 2> start{};
};

/// Spring with damper between points of two bodies, or of the world and a body.
struct SpringConfig {
  std::string name;
  std::string a = world_name, b;                // names of bodies; a may be world_name
  Vec3 p_A = Vec3::Zero(), p_B = Vec3::Zero();  // points, m; body axes about the centre of mass, or world
  double k = 0;                                 // N/m
  double g = 0;                                 // N s/m
  std::optional<double> rest_length{};          // m
};

/// Constant force in world axes.
struct ForceConfig {
  std::string name;
  std::string body;
  Vec3 p_B = Vec3::Zero();  // point, m, body axes about the centre of mass
  Vec3 F_W = Vec3::Zero();  // N
};

/// Gear between two coordinates of joints, q_b = ratio q_a + offset.
struct GearConfig {
  std::string name;
  std::string a, b;  // names of coordinates
  double ratio = 1;
  std::optional<double> offset{};     // rad or m
  std::optional<double> stiffness{};  // N m/rad or N/m; empty: rigid
  double damping = 0;                 // N m s/rad or N s/m
};

/// One coordinate of a built-in motion: offset + amplitude sin(2 pi f t + phase).
struct CoordinateMotion {
  std::string coordinate;                                         // name of a joint of the device
  double offset = 0, amplitude = 0, frequency_hz = 0, phase = 0;  // rad or m, Hz, rad
};

/// A built-in motion of the target, used without a --motion file.
/// p(t) = p_0 + A sin(2 pi f t + phase) per axis; q(t) = q_0 qz(.) qy(.) qx(.) of the same form per angle.
struct MotionConfig {
  Vec3 amplitude = Vec3::Zero(), frequency_hz = Vec3::Zero(), phase = Vec3::Zero();  // m, Hz, rad
  Vec3 angle_amplitude = Vec3::Zero(), angle_frequency_hz = Vec3::Zero(),
       angle_phase = Vec3::Zero();  // rad (z, y, x)
  Pose X_WD;                        // centre of the motion
  // Wrench of the hand for admittance devices, which take no pose, in world axes about the body's origin.
  // f(t) = F sin(2 pi f t + phase), tau(t) = T sin(2 pi f t + phase) per axis (x, y, z).
  Vec3 force_amplitude = Vec3::Zero(), torque_amplitude = Vec3::Zero();  // N, N m
  // Motions of the device's joints instead of the target's pose: each handle moves its body. Other joints
  // rest at zero.
  std::vector<CoordinateMotion> joints;
  std::vector<HoldConfig> holds{};  // in the order of time
};

/// Names of CouplingMode in scene files, in its order.
inline constexpr std::array coupling_names{"god-object", "imposed"};

enum class CouplingMode : std::uint8_t {
  god_object,  // couplings pull bodies to their targets
  imposed,     // bodies are placed at their targets in every step, regardless of contacts
};

struct SceneConfig {
  std::string name;
  std::string about;
  double step = 1e-3;    // h, s; period of SYNC on the buses of its device
  double duration = 10;  // s
  std::string integrator = "tr-bdf2";
  CouplingMode coupling = CouplingMode::god_object;
  Vec3 gravity = Vec3::Zero();       // m/s^2
  std::vector<BodyConfig> bodies;    // parents before children
  std::vector<JointConfig> joints;   // a tree: each body is the child of at most one joint
  std::vector<JointConfig> loops{};  // joints that close loops of the tree
  std::vector<SpringConfig> springs{};
  std::vector<ForceConfig> forces{};
  std::vector<GearConfig> gears{};
  std::vector<NetConfig> nets{};
  int net_iterations = NetParams<1, 1>{}.max_iterations;  // largest number in a stage, for all nets
  std::vector<ObstacleConfig> obstacles;
  std::size_t world_planes = 0;         // planes of another simulation (platform/session/world.h)
  std::vector<ContactConfig> contacts;  // one for every pair of materials that can meet
  std::optional<DeviceConfig> device;   // drives the bodies that have a handle
  std::optional<MotionConfig> motion;
  WireConfig wire;
  std::vector<FaultConfig> faults{};  // in the order of time
};

/// Returns the indices of the bodies with a target: the coupled ones; without any, the first body if an
/// admittance device pushes it. The device drives the first of them.
inline std::vector<std::size_t> driven_bodies(const SceneConfig& scene) {
  std::vector<std::size_t> driven;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].coupling) driven.push_back(i);
  }
  const bool pushed = scene.device && scene.device->kind == DeviceKind::admittance;
  if (driven.empty() && pushed && !scene.bodies.empty()) driven.push_back(0);
  return driven;
}

/// Returns the index of the body of this name; none for world_name or an unknown name.
inline std::optional<std::size_t> body_named(const SceneConfig& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].name == name) return i;
  return std::nullopt;
}

/// Coordinate of a joint of the scene.
struct CoordinateOfJoint {
  const JointConfig* joint = nullptr;  // null: no joint has a coordinate of this name
  std::size_t number = 0;
};
inline CoordinateOfJoint coordinate_named(const SceneConfig& scene, const std::string& name) {
  for (const JointConfig& joint : scene.joints)
    for (std::size_t c = 0; c < joint.coordinates.size(); ++c)
      if (joint.coordinates[c] == name) return {&joint, c};
  return {};
}

/// Returns the names of springs, gears and closing joints, whose forces a run reports, in its order.
inline std::vector<std::string> term_names(const SceneConfig& scene) {
  std::vector<std::string> names;
  for (const SpringConfig& spring : scene.springs) names.push_back(spring.name);
  for (const GearConfig& gear : scene.gears) names.push_back(gear.name);
  for (const JointConfig& loop : scene.loops) names.push_back(loop.name);
  return names;
}

/// Numbers of springs, forces and the like, by kind of the core's term.
struct TermCounts {
  std::size_t springs = 0, coordinate_springs = 0, loops = 0, forces = 0;
  std::size_t most() const { return std::max({springs, coordinate_springs, loops, forces}); }
};
inline TermCounts term_counts(const SceneConfig& scene) {
  TermCounts n{.springs = scene.springs.size(),
               .coordinate_springs = scene.gears.size(),
               .loops = scene.loops.size(),
               .forces = scene.forces.size()};
  for (const JointConfig& joint : scene.joints) n.coordinate_springs += joint.springs.size();
  return n;
}

/// True if the device grips and releases coupled bodies, one at a time; otherwise it is tied to them.
inline bool grips_bodies(const SceneConfig& scene) {
  return scene.device && (!scene.device->holds.empty() || scene.device->grab_radius ||
                          (scene.motion && !scene.motion->holds.empty()));
}

/// Returns the names of motion columns: the driven bodies; the device if it grips bodies.
inline std::vector<std::string> motion_targets(const SceneConfig& scene) {
  if (grips_bodies(scene)) return {scene.device->name};
  std::vector<std::string> names;
  for (const std::size_t body : driven_bodies(scene)) names.push_back(scene.bodies[body].name);
  return names;
}

/// Returns joints and handles of the device, measured by its rig or moved by a motion alone; null if there
/// are none.
inline const KinematicTreeParams* device_tree(const SceneConfig& scene) {
  if (!scene.device) return nullptr;
  if (scene.device->rig) return &scene.device->rig->tree;
  return scene.device->unmeasured_tree ? &*scene.device->unmeasured_tree : nullptr;
}

/// Returns for each handle of the device its index in motion_targets(), if any.
inline std::vector<std::optional<std::size_t>> driven_by_handles(const SceneConfig& scene) {
  std::vector<std::optional<std::size_t>> by_handle;
  const KinematicTreeParams* const tree = device_tree(scene);
  if (tree == nullptr) return by_handle;
  if (grips_bodies(scene)) return {0};
  const std::vector<std::size_t> driven = driven_bodies(scene);
  for (const HandleParams& handle : tree->handles) {
    by_handle.emplace_back();
    for (std::size_t i = 0; i < driven.size(); ++i)
      if (scene.bodies[driven[i]].name == handle.body) by_handle.back() = i;
  }
  return by_handle;
}

/// True if a device of this kind displays force, by the torque of its drives.
constexpr bool shows_force(DeviceKind kind) noexcept {
  return kind == DeviceKind::impedance || kind == DeviceKind::relative;
}

/// Returns the gains of the wrench (8) that the device displays of a body; zero if it displays no force. A
/// display ratio scales the force as it scales the target's shift: the work of the hand is the tool's.
inline SpringParams displayed_gains(const SceneConfig& scene, const BodyConfig& body) {
  if (!body.feedback || !scene.device || !shows_force(scene.device->kind)) return {};
  SpringParams gains = *body.feedback;
  gains.k *= scene.device->display_ratio;
  gains.g *= scene.device->display_ratio;
  return gains;
}

/// Returns the index in motion_targets() of a tracker's tool.
inline std::size_t driven_by_tool(const SceneConfig& scene, const TrackedToolParams& tool) {
  if (grips_bodies(scene)) return 0;
  const std::vector<std::size_t> driven = driven_bodies(scene);
  std::size_t i = 0;
  while (i < driven.size() && scene.bodies[driven[i]].name != tool.body) ++i;
  return i;
}

}  // namespace godobject
