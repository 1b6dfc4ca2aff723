#include "platform/scene/joint/kinds.h"

#include <cmath>

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

}  // namespace

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

}  // namespace godobject
