// Every kind of joint: a new one is a file, and named here.
#pragma once

#include "core/joint/ball.h"
#include "core/joint/cylindrical.h"
#include "core/joint/fixed.h"
#include "core/joint/hinge.h"
#include "core/joint/slider.h"
#include "core/joint/universal.h"

namespace godobject {

/// How a body may move against its parent; free: it hangs on nothing.
enum class JointKind : std::uint8_t { free, fixed, ball, hinge, slider, cylindrical, universal };

/// Calls f with the joint type of this kind; nothing for `free`.
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

/// Turns and slides of a joint of this kind.
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
