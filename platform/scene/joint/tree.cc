// Kinds of joints, their tree, and the device implied by it.
#include "platform/scene/joint/joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/math/pose.h"

namespace godobject {
namespace {

struct Words {
  const char* name = nullptr;  // beyond the last kind
  const char* meaning = nullptr;
};

Words words(std::size_t kind) noexcept {
  Words words;
  with_joint(static_cast<JointKind>(kind), [&](auto joint) { words = {joint.name, joint.meaning}; });
  return words;
}

JointFrames at_zero() noexcept {
  return {.R_WP = Mat3::Identity(), .R_WC = Mat3::Identity(), .d_W = Vec3::Zero()};
}

double angle_between(const Vec3& a, const Vec3& b) noexcept {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Pose of a body of the instrument on the device.
struct Place {
  std::string link;  // name of the joint that carries it, or base_name
  Pose X_LB;
};

class DeviceBuilder {
 public:
  explicit DeviceBuilder(const SceneConfig& scene)
      : scene_(scene), misses_bodies_(!joints_have_bodies(scene)) {
    places_[world_name] = {base_name, {}};
  }

  DeviceTree build() {
    for (const BodyConfig& body : scene_.bodies) {
      const auto joint = std::ranges::find(scene_.joints, body.name, &JointConfig::child);
      if (joint != scene_.joints.end() && places_.contains(joint->parent))
        add(*joint, places_[joint->parent]);
    }
    if (misses_bodies_) add_joints_without_place();
    for (const std::size_t body : driven_bodies(scene_)) hold(scene_.bodies[body].name);
    return std::move(device_);
  }

 private:
  /// Adds joints that nothing connects to the world. Their coordinates are then known where others name them,
  /// and the missing body remains the only error.
  void add_joints_without_place() {
    for (const JointConfig& joint : scene_.joints)
      if (!places_.contains(joint.child)) add(joint, places_[world_name]);
  }

  /// Adds the coordinates of a joint one after the other, from the parent's frame to the child's.
  void add(const JointConfig& joint, const Place& parent) {
    Place at{parent.link, parent.X_LB * joint.X_BP};
    if (is_ball(joint.kind)) {
      device_.errors.push_back("joint '" + joint.name +
                               "' is a ball joint, which encoders cannot measure: describe the device by "
                               "[[device.joint]] and [[device.handle]] tables");
      return;
    }
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
      if (joint.coordinates[i] == base_name)
        device_.errors.push_back("coordinate '" + joint.coordinates[i] + "' of joint '" + joint.name +
                                 "' is the name of the device's base: choose another name");
      device_.tree.joints.push_back(
          {.name = joint.coordinates[i],
           .parent = at.link,
           .kind = is_turn(joint.kind, i) ? DeviceJointKind::hinge : DeviceJointKind::slider,
           .X_PJ = at.X_LB,
           .axis_J = axis_at_zero(joint.kind, i)});
      at = {joint.coordinates[i], {}};
    }
    places_[joint.child] = {at.link, at.X_LB * inverse(joint.X_BC)};
  }

  void hold(const std::string& body) {
    const auto at = places_.find(body);
    const bool moves = at != places_.end() && at->second.link != base_name;
    if (moves) {
      device_.tree.handles.push_back({.body = body, .joint = at->second.link, .X_LH = at->second.X_LB});
    } else if (misses_bodies_) {
      device_.tree.handles.push_back({.body = body, .joint = base_name, .X_LH = {}});
    } else if (device_.errors.empty()) {
      device_.errors.push_back("no joints with coordinates connect the world to body '" + body +
                               "', so no handle can move it: describe the device by [[device.joint]] and "
                               "[[device.handle]] tables, or remove its [body.coupling]");
    }
  }

  const SceneConfig& scene_;
  const bool misses_bodies_;
  std::map<std::string, Place> places_;
  DeviceTree device_;
};

}  // namespace

// ---- kinds ----------------------------------------------------------------------------------------

std::vector<std::string> joint_kind_names() {
  std::vector<std::string> names;
  for (std::size_t kind = 1; words(kind).name != nullptr; ++kind) names.emplace_back(words(kind).name);
  return names;
}

std::string joint_kind_meanings() {
  std::string text;
  for (std::size_t kind = 1; words(kind).name != nullptr; ++kind)
    text += std::string(kind == 1 ? "" : "; ") + words(kind).meaning;
  return text;
}

Vec3 axis_at_zero(JointKind kind, std::size_t i) noexcept {
  Vec3 axis = Vec3::Zero();
  with_joint(kind, [&](auto joint) {
    const auto motion = joint.motion(at_zero());
    if (i < motion.turn.size()) axis = motion.turn[i];
    else if (i - motion.turn.size() < motion.slide.size()) axis = motion.slide[i - motion.turn.size()];
  });
  return axis;
}

bool is_along_z(JointKind kind) noexcept {
  for (std::size_t i = 0; i < num_coordinates(kind); ++i)
    if (axis_at_zero(kind, i) != Vec3::UnitZ()) return false;
  return num_coordinates(kind) > 0;
}

/// Two coordinates are named as a turn and a slide, or by their axes.
std::vector<std::string> default_coordinates(const std::string& joint, JointKind kind) {
  const std::size_t n = num_coordinates(kind);
  if (n == 1) return {joint};
  const bool alike = n == 2 && is_turn(kind, 0) == is_turn(kind, 1);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Index axis = 0;
    axis_at_zero(kind, i).maxCoeff(&axis);
    if (alike) names.push_back(joint + "_" + "xyz"[axis]);
    else names.push_back(joint + (is_turn(kind, i) ? "_turn" : "_slide"));
  }
  return names;
}

/// One turn keeps its axis common to both frames. Two turns keep the angle between the parent's first axis
/// and the child's second.
double angular_gap(JointKind kind, const JointFrames& X) noexcept {
  const Vec3 first = axis_at_zero(kind, 0), second = axis_at_zero(kind, 1);
  switch (num_axes(kind).turns) {
    case 0: return Eigen::AngleAxis<Real>(X.R_WP.transpose() * X.R_WC).angle();
    case 1: return angle_between(X.R_WP * first, X.R_WC * first);
    case 2: return std::abs(angle_between(first, second) - angle_between(X.R_WP * first, X.R_WC * second));
    default: return 0;
  }
}

// ---- tree -----------------------------------------------------------------------------------------

JointTree::Added JointTree::add(const JointConfig& joint) {
  if (joint.parent == joint.child)
    return {"joint '" + joint.name + "' joins body '" + joint.child +
            "' to itself: give it another parent or child"};
  if (const auto joints = way(joint.parent, joint.child)) {
    if (joints->size() == 1)
      return {"joints '" + joints->front() + "' and '" + joint.name + "' both join '" + joint.parent +
              "' and '" + joint.child +
              "', which constrains some motion twice: remove one of them, or make them one joint of another "
              "kind"};
    return {"", *joints};
  }
  const auto earlier = std::ranges::find(edges_, joint.child, &Edge::child);
  if (earlier != edges_.end())
    return {"body '" + joint.child + "' is the child of joints '" + earlier->name + "' and '" + joint.name +
            "': swap parent and child of one of them"};
  edges_.push_back({.name = joint.name, .parent = joint.parent, .child = joint.child});
  return {};
}

std::optional<std::vector<std::string>> JointTree::way(const std::string& from, const std::string& to) const {
  std::vector<std::string> joints;
  if (!extend_way(from, to, joints)) return std::nullopt;
  return joints;
}

/// Searches the earlier joints, which are a forest: a path that does not turn back meets no body twice.
bool JointTree::extend_way(const std::string& from, const std::string& to,
                           std::vector<std::string>& joints) const {
  if (from == to) return true;
  for (const Edge& edge : edges_) {
    const bool turns_back = !joints.empty() && joints.back() == edge.name;
    if (turns_back || (edge.parent != from && edge.child != from)) continue;
    joints.push_back(edge.name);
    if (extend_way(edge.parent == from ? edge.child : edge.parent, to, joints)) return true;
    joints.pop_back();
  }
  return false;
}

std::vector<BodyConfig> parents_first(const std::vector<BodyConfig>& bodies,
                                      const std::vector<JointConfig>& joints) {
  std::vector<BodyConfig> ordered;
  std::vector<bool> taken(bodies.size(), false);
  const auto is_there = [&](const std::string& name) {
    return name == world_name || std::ranges::find(ordered, name, &BodyConfig::name) != ordered.end();
  };
  const auto can_be_next = [&](std::size_t i) {
    if (taken[i]) return false;
    const auto joint = std::ranges::find(joints, bodies[i].name, &JointConfig::child);
    return joint == joints.end() || is_there(joint->parent);
  };
  while (ordered.size() < bodies.size()) {
    std::size_t next = 0;
    while (next < bodies.size() && !can_be_next(next)) ++next;
    if (next == bodies.size()) return bodies;  // not a tree
    taken[next] = true;
    ordered.push_back(bodies[next]);
  }
  return ordered;
}

// ---- device ---------------------------------------------------------------------------------------

DeviceTree device_from_joints(const SceneConfig& scene) { return DeviceBuilder(scene).build(); }

}  // namespace godobject
