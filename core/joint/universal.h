// Universal joint: rotation about the parent's x axis, then about the child's y axis.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

struct UniversalJoint {
  static constexpr const char* name = "universal";
  static constexpr const char* meaning =
      "turn about x of the parent's frame, then about y of the child's";  // motion of the child against the
                                                                          // parent

  static JointMotion<2, 0> motion(const JointFrames& X) noexcept {
    const Vec3 x = X.R_WP.col(0), y = X.R_WC.col(1);
    JointMotion<2, 0> m;
    m.turn = {x, y};
    m.e_w = x.cross(y) * -x.dot(y);  // x.y = 0, and bounded where x and y come to lie on one line
    m.e_v = X.d_W;
    return m;
  }

  // R_PC = Rx(q0) Ry(q1)
  static JointCoordinates coordinates(const JointFrames& X) noexcept {
    const Mat3 &P = X.R_WP, &C = X.R_WC;
    return {angle_of(P.col(2).dot(C.col(1)), P.col(1).dot(C.col(1))),
            angle_of(P.col(0).dot(C.col(2)), P.col(0).dot(C.col(0)))};
  }

  static JointFrames at(const JointFrames& X, const JointCoordinates& q) noexcept {
    return {.R_WP = turned(turned(X.R_WP, 0, q[0]), 1, q[1]), .R_WC = X.R_WC, .d_W = X.d_W};
  }
};

}  // namespace godobject
