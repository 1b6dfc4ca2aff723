// Ball joint: all rotations about one point.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

struct BallJoint {
  static constexpr const char* name = "ball";
  static constexpr const char* meaning = "turn about a point";  // motion of the child against the parent

  static JointMotion<3, 0> motion(const JointFrames& X) noexcept {
    JointMotion<3, 0> m;
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
