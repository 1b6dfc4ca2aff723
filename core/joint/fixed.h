// Fixed joint: no relative motion.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

/// Returns the rotation of the child's frame against the parent's, world axes, to second order in the angle.
inline Vec3 misalignment(const JointFrames& X) noexcept {
  Vec3 e = Vec3::Zero();
  for (int i = 0; i < 3; ++i) e += X.R_WP.col(i).cross(X.R_WC.col(i));
  return Real(0.5) * e;
}

struct FixedJoint {
  static constexpr const char* name = "fixed";
  static constexpr const char* meaning = "nothing";  // motion of the child against the parent

  static JointMotion<0, 0> motion(const JointFrames& X) noexcept {
    JointMotion<0, 0> m;
    m.e_w = misalignment(X);
    m.e_v = X.d_W;
    return m;
  }
};

}  // namespace godobject
