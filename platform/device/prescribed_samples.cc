#include "platform/device/hand_device.h"

#include <algorithm>

namespace godobject {

PrescribedSamples::PrescribedSamples(const SceneConfig& scene) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  if (!driven.empty()) first_driven_ = driven.front();
  for (const JointConfig& joint : scene.joints) {
    if (!joint.prescribed) continue;
    const std::vector<DeviceJoint>& device = device_tree(scene)->joints;
    Joint prescribed{.body = *body_named(scene, joint.child), .num_coordinates = joint.coordinates.size()};
    prescribed.driven = scene.bodies[prescribed.body].coupling.has_value();
    for (std::size_t i = 0; i < prescribed.num_coordinates; ++i)
      prescribed.device_joints[i] =
          std::ranges::find(device, joint.coordinates[i], &DeviceJoint::name) - device.begin();
    joints_.push_back(prescribed);
  }
}

void PrescribedSamples::write(const JointTarget& device, bool valid,
                              std::span<BodySample> samples) const noexcept {
  for (const Joint& joint : joints_) {
    BodySample& sample = samples[joint.body];
    sample.valid = valid;
    for (std::size_t i = 0; i < joint.num_coordinates; ++i) {
      sample.joint.q[static_cast<Eigen::Index>(i)] = device.q[joint.device_joints[i]];
      sample.joint.q_dot[static_cast<Eigen::Index>(i)] = device.q_dot[joint.device_joints[i]];
    }
    if (!joint.driven && first_driven_) sample.engaged = samples[*first_driven_].engaged;
  }
}

}  // namespace godobject
