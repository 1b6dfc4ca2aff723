#include "platform/scene/joint/device_from_joints.h"

#include <algorithm>
#include <map>
#include <optional>

#include "core/device/holding.h"
#include "platform/scene/joint/kinds.h"

namespace godobject {
namespace {

Pose inverse(const Pose& X) { return {-(X.q.conjugate() * X.p), X.q.conjugate()}; }

/// Pose of a body of the instrument on the device.
struct Place {
  std::string link;  // name of the joint that carries it, or base_name
  Pose X_LB;
};

class DeviceBuilder {
 public:
  explicit DeviceBuilder(const SceneConfig& scene) : scene_(scene) { places_[world_name] = {base_name, {}}; }

  DeviceTree build() {
    for (const BodyConfig& body : scene_.bodies) {
      const auto joint = std::ranges::find(scene_.joints, body.name, &JointConfig::child);
      if (joint != scene_.joints.end()) add(*joint);
    }
    for (const std::size_t body : driven_bodies(scene_)) hold(scene_.bodies[body].name);
    return std::move(device_);
  }

 private:
  /// Adds the coordinates of a joint one after the other, from the parent's frame to the child's.
  void add(const JointConfig& joint) {
    const auto parent = places_.find(joint.parent);
    if (parent == places_.end()) return;  // no joint connects it to the world
    Place at{parent->second.link, composed(parent->second.X_LB, joint.X_BP)};
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
    places_[joint.child] = {at.link, composed(at.X_LB, inverse(joint.X_BC))};
  }

  void hold(const std::string& body) {
    const auto at = places_.find(body);
    const bool moves = at != places_.end() && at->second.link != base_name;
    if (moves) {
      device_.tree.handles.push_back({.body = body, .joint = at->second.link, .X_LH = at->second.X_LB});
    } else if (device_.errors.empty()) {
      device_.errors.push_back("no joints with coordinates connect the world to body '" + body +
                               "', so no handle can move it: describe the device by [[device.joint]] and "
                               "[[device.handle]] tables, or remove its [body.coupling]");
    }
  }

  const SceneConfig& scene_;
  std::map<std::string, Place> places_;
  DeviceTree device_;
};

}  // namespace

DeviceTree device_from_joints(const SceneConfig& scene) { return DeviceBuilder(scene).build(); }

}  // namespace godobject
