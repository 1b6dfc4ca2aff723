// List of all kinds of joints. A new kind is one file, named here.
#pragma once

#include "core/joint/ball.h"
#include "core/joint/cylindrical.h"
#include "core/joint/fixed.h"
#include "core/joint/hinge.h"
#include "core/joint/slider.h"
#include "core/joint/universal.h"

namespace godobject {

/// Motion of a body against its parent; free: no joint.
enum class JointKind : std::uint8_t { free, fixed, ball, hinge, slider, cylindrical, universal };

/// Calls f with the joint type of this kind; does nothing for `free`.
template <class F>
void with_joint(JointKind kind, F&& f) noexcept {
  switch (kind) {
    case JointKind::free: return;
    case JointKind::fixed: return f(FixedJoint{});
    case JointKind::ball: return f(BallJoint{});
    case JointKind::hinge: return f(HingeJoint{});
    case JointKind::slider: return f(SliderJoint{});
    case JointKind::cylindrical: return f(CylindricalJoint{});
    case JointKind::universal: return f(UniversalJoint{});
  }
}

/// Numbers of rotations and translations of a joint of this kind.
struct NumAxes {
  int turns = 0, slides = 0;
};
inline NumAxes num_axes(JointKind kind) noexcept {
  NumAxes n;
  with_joint(kind, [&](auto joint) {
    using Motion = decltype(joint.motion(JointFrames{}));
    n = {.turns = Motion::num_turns, .slides = Motion::num_slides};
  });
  return n;
}

}  // namespace godobject
