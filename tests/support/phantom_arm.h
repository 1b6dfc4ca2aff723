// A six-joint arm like the large Phantom devices: yaw, shoulder, elbow, and a gimbal whose three axes meet in
// the handle. At q = 0 the handle is at the world origin, axes aligned.
#pragma once

#include <array>

#include "hal/rig/params.h"

namespace godobject::test {

inline KinematicTreeParams phantom_arm() {
  constexpr double link_m = 0.35;  // upper arm along x, forearm down along -z
  const auto at = [](double x, double z) {
    Pose X;
    X.p = Vec3(x, 0, z);
    return X;
  };
  KinematicTreeParams arm;
  arm.X_WB = at(-link_m, link_m);
  arm.joints = {
      {.name = "yaw", .axis_J = Vec3::UnitZ()},
      {.name = "shoulder", .axis_J = Vec3::UnitY()},
      {.name = "elbow", .X_PJ = at(link_m, 0), .axis_J = Vec3::UnitY()},
      {.name = "gimbal_z", .X_PJ = at(0, -link_m), .axis_J = Vec3::UnitZ()},
      {.name = "gimbal_x", .axis_J = Vec3::UnitX()},
      {.name = "gimbal_y", .axis_J = Vec3::UnitY()},
  };
  arm.handles = {{.body = "tool", .joint = "gimbal_y"}};
  return arm;
}

}  // namespace godobject::test
