// Session: construction and validation.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "platform/session/passivity.h"
#include "platform/session/session.h"

namespace godobject {
namespace {

constexpr PoseError advised_offset{.m = 0.1, .rad = 0.5}, largest_offset{.m = 1, .rad = 3};

/// True if the offset exceeds the bound by more than rounding.
bool exceeds(const PoseError& offset, const PoseError& bound) {
  return offset.m > 1.001 * bound.m || offset.rad > 1.001 * bound.rad;
}

std::string text_of(const std::string& body, const PoseError& offset) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "body '%s' starts %.3f m and %.3f rad from its target",
                body.c_str(), offset.m, offset.rad);
  return text.data();
}

/// Warns of degrees in place of radians: hardly a hinge starts more than a turn from its zero.
void check_joints(const Session& session, std::vector<std::string>& warnings) {
  const std::optional<JointTarget> start = session.joints_at_start();
  if (!start) return;
  const std::vector<DeviceJoint>& joints = device_tree(session.scene())->joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double q = start->q[static_cast<Eigen::Index>(i)];
    if (joints[i].kind != DeviceJointKind::hinge || std::abs(q) <= 2 * pi) continue;
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(),
                  "joint '%s' starts at %.4g rad, more than a turn: give angles in radians",
                  joints[i].name.c_str(), q);
    warnings.emplace_back(text.data());
  }
}

/// Checks that the motion moves the device's joints if any joint of the scene is prescribed.
void check_motion_of_joints(const SceneConfig& scene, const Motion& motion, bool real,
                            std::vector<std::string>& errors) {
  if (motion.has_joints() || real) return;
  for (const JointConfig& joint : scene.joints)
    if (joint.prescribed)
      errors.push_back(
          "joint '" + joint.name +
          "' is imposed: the motion must be one of the device's joints; give --motion a column for "
          "each, or the scene [[motion.joint]] tables");
}

}  // namespace

Session::Session(SceneConfig scene, Motion motion)
    : scene_(std::move(scene)),
      motion_(std::move(motion)),
      driven_(driven_bodies(scene_)),
      joint_coordinates_(scene_),
      samples_(scene_.bodies.size()),
      F_hand_W_(scene_.bodies.size()),
      handed_(scene_, motion_),
      phases_(scene_.step) {
  phases_.add(handed_);
}

Session::Made Session::make(SceneConfig scene, Motion motion) {
  return build(std::move(scene), std::move(motion), nullptr);
}

Session::Made Session::make(SceneConfig scene, Motion motion, std::unique_ptr<RigLink> buses) {
  return make(std::move(scene), std::move(motion),
              DeviceParts{.buses = std::move(buses), .trackers = {}, .truth = {}});
}

Session::Made Session::make(SceneConfig scene, Motion motion, DeviceParts device) {
  return build(std::move(scene), std::move(motion), &device);
}

Session::Made Session::build(SceneConfig scene, Motion motion, DeviceParts* device) {
  Made made;
  const bool real = device != nullptr && !device->truth;
  check_motion_of_joints(scene, motion, real, made.errors);
  if (!made.errors.empty()) return made;
  std::unique_ptr<Session> s(new Session(std::move(scene), std::move(motion)));
  s->real_ = real;
  for (std::size_t i = 0; i < s->driven_.size(); ++i)
    s->samples_[s->driven_[i]] = s->handed_.sample(std::min(i, s->motion_.num_bodies() - 1), 0);
  if (grips_bodies(s->scene_)) {
    s->grip_.emplace(s->scene_);
    for (const std::size_t body : s->driven_) s->samples_[body].engaged = false;
  }
  s->handed_.write_joints(0, s->samples_);
  if (device != nullptr && !s->driven_.empty()) s->connect(std::move(*device), made.errors);
  if (!made.errors.empty()) return made;

  std::string why_not;
  s->engine_ = make_engine(s->scene_, s->samples_, why_not);
  if (!s->engine_) {
    made.errors.push_back(why_not);
    return made;
  }
  if (s->truth_) s->truth_->start(s->scene_, s->samples_);
  s->swings_.emplace(s->scene_, s->grip_ ? 1 : s->driven_.size());
  made.session = std::move(s);
  return made;
}

void Session::connect(DeviceParts device, std::vector<std::string>& errors) {
  const bool has_rig = scene_.device && scene_.device->rig;
  const bool has_trackers = scene_.device && !scene_.device->trackers.empty();
  if (!has_rig && !has_trackers)
    errors.push_back("scene '" + scene_.name +
                     "' describes no buses, encoders and joints: add them, or run it with --bus direct");
  if (has_rig) {
    for (const std::string& error : RigDevice::complaints(scene_)) errors.push_back(error);
    if (!device.buses)
      errors.push_back("the device of scene '" + scene_.name + "' has buses: pass them to make()");
    if (errors.empty())
      phases_.add(rig_.emplace(scene_, std::move(device.buses),
                               passivity_controllers(scene_, godobject::joints_at_start(scene_, motion_))));
  }
  if (has_trackers) {
    const std::vector<TrackerParams>& trackers = scene_.device->trackers;
    for (std::size_t i = device.trackers.size(); i < trackers.size(); ++i)
      errors.push_back("tracker '" + trackers[i].name + "' of the scene has no port: give --tracker " +
                       trackers[i].name + "=PORT, or --tracker scene");
    if (errors.empty()) phases_.add(trackers_.emplace(scene_, std::move(device.trackers), device.clock));
  }
  truth_ = std::move(device.truth);
}

StartCheck check_start(const Session& session) {
  StartCheck check;
  check_joints(session, check.warnings);
  const SceneConfig& scene = session.scene();
  for (const std::size_t body : driven_bodies(scene)) {
    const std::optional<PoseError> offset = session.offset_at_start(body);
    if (!offset || !exceeds(*offset, advised_offset)) continue;
    const std::string what = text_of(scene.bodies[body].name, *offset);
    if (exceeds(*offset, largest_offset))
      check.errors.push_back(what +
                             "; at most 1 m and 3 rad are admissible: give lengths in metres and angles in "
                             "radians, or start the motion at the body");
    else check.warnings.push_back(what + ", and the coupling pulls it there: start the motion at the body");
  }
  return check;
}

}  // namespace godobject
