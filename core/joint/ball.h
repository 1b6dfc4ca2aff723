// Ball joint: all turns about one point.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

struct BallJoint {
  static constexpr JointKind kind = JointKind::ball;

  static JointMotion<3, 0> motion(const JointFrames& X) noexcept {
    JointMotion<3, 0> m;
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
