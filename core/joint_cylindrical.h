// Cylindrical joint: a turn about and a shift along the z axes of both frames.
#pragma once

#include "core/joint.h"

namespace godobject {

struct CylindricalJoint {
  static constexpr JointKind kind = JointKind::cylindrical;
  static constexpr int dof = 2;

  static JointMotion<2> motion(const JointFrames& X) noexcept {
    const Vec3 z = X.R_WP.col(2);
    JointMotion<2> m;
    m.S_w.col(0) = z;
    m.S_v.col(1) = z;
    m.e_w = z.cross(X.R_WC.col(2));
    m.e_v = X.d_W - z * z.dot(X.d_W);
    return m;
  }
};

}  // namespace godobject
