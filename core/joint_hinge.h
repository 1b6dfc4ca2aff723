// Hinge: a turn about the z axes of both frames.
#pragma once

#include "core/joint.h"

namespace godobject {

struct HingeJoint {
  static constexpr JointKind kind = JointKind::hinge;
  static constexpr int dof = 1;

  static JointMotion<1> motion(const JointFrames& X) noexcept {
    JointMotion<1> m;
    m.S_w = X.R_WP.col(2);
    m.e_w = X.R_WP.col(2).cross(X.R_WC.col(2));
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
