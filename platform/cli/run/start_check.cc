#include "platform/cli/run/start_check.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "platform/scene/checks.h"

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
void check_joints(const Session& session, const std::string& file, std::vector<std::string>& warnings) {
  const std::optional<JointTarget> start = session.joints_at_start();
  if (!start) return;
  const std::vector<DeviceJoint>& joints = device_tree(session.scene())->joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double q = start->q[static_cast<Eigen::Index>(i)];
    if (joints[i].kind != DeviceJointKind::hinge || std::abs(q) <= 2 * pi) continue;
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(),
                  ": joint '%s' starts at %.4g rad, more than a turn: give angles in radians",
                  joints[i].name.c_str(), q);
    warnings.push_back(file + text.data());
  }
}

}  // namespace

void check_start(const Session& session, const std::string& file, std::vector<std::string>& warnings,
                 std::vector<std::string>& errors) {
  check_joints(session, file, warnings);
  const SceneConfig& scene = session.scene();
  for (const std::size_t body : driven_bodies(scene)) {
    const std::optional<PoseError> offset = session.offset_at_start(body);
    if (!offset || !exceeds(*offset, advised_offset)) continue;
    const std::string what = file + ": " + text_of(scene.bodies[body].name, *offset);
    if (exceeds(*offset, largest_offset))
      errors.push_back(what +
                       "; at most 1 m and 3 rad are admissible: give lengths in metres and angles in "
                       "radians, or start the motion at the body");
    else warnings.push_back(what + ", and the coupling pulls it there: start the motion at the body");
  }
}

void check_speed(const SceneConfig& scene, const Motion& motion, double duration, const std::string& file,
                 std::vector<std::string>& warnings) {
  const MotionSpeed most = fastest(motion, duration, scene.step);
  if (most.speed <= max_hand_speed) return;
  std::array<char, 240> text{};
  std::snprintf(
      text.data(), text.size(),
      ": the motion moves the target of '%s' at %.3g m/s at %.3g s; expected are at most %g m/s, the "
      "speed of a hand: give lengths in m and times in s, or slow the motion down",
      motion_targets(scene)[most.body].c_str(), most.speed, most.t, max_hand_speed);
  warnings.push_back(file + text.data());
}

}  // namespace godobject
