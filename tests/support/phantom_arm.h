// A six-joint arm in the manner of the large Phantom devices: yaw, shoulder, elbow, and a gimbal
// whose three axes meet in the handle. At q = 0 the handle is at the world origin, axes aligned.
#pragma once

#include <array>

#include "hal/rig_params.h"

namespace godobject::test {

inline ChainParams phantom_arm() {
  constexpr double link_m = 0.35;  // upper arm along x, forearm down along -z
  const auto at = [](double x, double z) {
    Pose X;
    X.p = Vec3(x, 0, z);
    return X;
  };
  ChainParams chain;
  chain.X_WB = at(-link_m, link_m);
  chain.joints = {
      {"yaw", ChainJointKind::hinge, Pose{}, Vec3::UnitZ()},
      {"shoulder", ChainJointKind::hinge, Pose{}, Vec3::UnitY()},
      {"elbow", ChainJointKind::hinge, at(link_m, 0), Vec3::UnitY()},
      {"gimbal_z", ChainJointKind::hinge, at(0, -link_m), Vec3::UnitZ()},
      {"gimbal_x", ChainJointKind::hinge, Pose{}, Vec3::UnitX()},
      {"gimbal_y", ChainJointKind::hinge, Pose{}, Vec3::UnitY()},
  };
  return chain;
}

}  // namespace godobject::test
