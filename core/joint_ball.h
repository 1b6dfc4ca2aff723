// Ball joint: all turns about one point.
#pragma once

#include "core/joint.h"

namespace godobject {

struct BallJoint {
  static constexpr JointKind kind = JointKind::ball;
  static constexpr int dof = 3;

  static JointMotion<3> motion(const JointFrames& X) noexcept {
    JointMotion<3> m;
    m.S_w.setIdentity();
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
