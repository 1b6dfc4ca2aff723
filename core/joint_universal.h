// Universal joint: a turn about the parent's x axis, then one about the child's y axis.
#pragma once

#include "core/joint.h"

namespace godobject {

struct UniversalJoint {
  static constexpr JointKind kind = JointKind::universal;
  static constexpr int dof = 2;

  static JointMotion<2> motion(const JointFrames& X) noexcept {
    const Vec3 x = X.R_WP.col(0), y = X.R_WC.col(1);
    const Vec3 n = x.cross(y);
    JointMotion<2> m;
    m.S_w.col(0) = x;
    m.S_w.col(1) = y;
    m.e_w = n * (-x.dot(y) / n.squaredNorm());  // x.y = 0
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
