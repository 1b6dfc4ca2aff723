// Hinge: rotation about the z axes of both frames.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

struct HingeJoint {
  static constexpr const char* name = "hinge";
  static constexpr const char* meaning = "turn about z";  // motion of the child against the parent

  static JointMotion<1, 0> motion(const JointFrames& X) noexcept {
    JointMotion<1, 0> m;
    m.turn = {X.R_WP.col(2)};
    m.e_w = X.R_WP.col(2).cross(X.R_WC.col(2));
    m.e_v = X.d_W;
    return m;
  }

  static JointCoordinates coordinates(const JointFrames& X) noexcept {
    return {angle_of(X.R_WP.col(1).dot(X.R_WC.col(0)), X.R_WP.col(0).dot(X.R_WC.col(0))), 0};
  }

  /// Returns the frames at coordinates q, in the parent's frame.
  static JointFrames at(const JointFrames& X, const JointCoordinates& q) noexcept {
    return {.R_WP = turned(X.R_WP, 2, q[0]), .R_WC = X.R_WC, .d_W = X.d_W};
  }
};

}  // namespace godobject
