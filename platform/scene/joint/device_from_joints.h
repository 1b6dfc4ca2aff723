// A device with the kinematics of the virtual instrument: its joints are those of the scene.
#pragma once

#include <string>
#include <vector>

#include "hal/rig/params.h"
#include "platform/scene/scene.h"

namespace godobject {

struct DeviceTree {
  KinematicTreeParams tree;
  std::vector<std::string> errors;  // why there is no such device; then the tree is incomplete
};

/// A hinge or slider for each named coordinate, called like it, and a handle at the body frame of each
/// coupled body: at coordinates q the handles are where the bodies of the instrument would be. Bodies:
/// parents first.
DeviceTree device_from_joints(const SceneConfig& scene);

}  // namespace godobject
