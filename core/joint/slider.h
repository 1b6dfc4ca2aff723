// Slider: translation along the z axes of both frames.
#pragma once

#include "core/joint/fixed.h"

namespace godobject {

struct SliderJoint {
  static constexpr const char* name = "slider";
  static constexpr const char* meaning = "slide along z";  // motion of the child against the parent

  static JointMotion<0, 1> motion(const JointFrames& X) noexcept {
    const Vec3 z = X.R_WP.col(2);
    JointMotion<0, 1> m;
    m.slide = {z};
    m.e_w = misalignment(X);
    m.e_v = X.d_W - z * z.dot(X.d_W);
    return m;
  }

  static JointCoordinates coordinates(const JointFrames& X) noexcept { return {X.R_WP.col(2).dot(X.d_W), 0}; }

  static JointFrames at(const JointFrames& X, const JointCoordinates& q) noexcept {
    return {.R_WP = X.R_WP, .R_WC = X.R_WC, .d_W = X.d_W - q[0] * X.R_WP.col(2)};
  }
};

}  // namespace godobject
