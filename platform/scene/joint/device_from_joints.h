// A device with the kinematics of the virtual instrument, whose joints are those of the scene.
#pragma once

#include <string>
#include <vector>

#include "hal/rig/params.h"
#include "platform/scene/scene.h"

namespace godobject {

struct DeviceTree {
  KinematicTreeParams tree;
  std::vector<std::string> errors;  // reasons why there is no such device; if any, the tree is incomplete
};

/// Makes a hinge or slider for each named coordinate, with its name, and a handle at the frame of each
/// coupled body. At coordinates q the handles have the poses of the instrument's bodies. Bodies: parents
/// first.
DeviceTree device_from_joints(const SceneConfig& scene);

}  // namespace godobject
