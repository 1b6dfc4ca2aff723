// Cylindrical joint: rotation about and translation along the z axes of both frames.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

struct CylindricalJoint {
  static constexpr const char* name = "cylindrical";
  static constexpr const char* meaning = "turn about z and slide along it";  // motion of the child against
                                                                             // the parent

  static JointMotion<1, 1> motion(const JointFrames& X) noexcept {
    const Vec3 z = X.R_WP.col(2);
    JointMotion<1, 1> m;
    m.turn = {z};
    m.slide = {z};
    m.e_w = z.cross(X.R_WC.col(2));
    m.e_v = X.d_W - z * z.dot(X.d_W);
    return m;
  }

  static JointCoordinates coordinates(const JointFrames& X) noexcept {
    return {angle_of(X.R_WP.col(1).dot(X.R_WC.col(0)), X.R_WP.col(0).dot(X.R_WC.col(0))),
            X.R_WP.col(2).dot(X.d_W)};
  }

  static JointFrames at(const JointFrames& X, const JointCoordinates& q) noexcept {
    return {.R_WP = turned(X.R_WP, 2, q[0]), .R_WC = X.R_WC, .d_W = X.d_W - q[1] * X.R_WP.col(2)};
  }
};

}  // namespace godobject
