// Joints of the scene that the device's joints of the same names lead.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "platform/engine/engine.h"
#include "platform/scene/scene.h"

namespace godobject {

class LedJoints {
 public:
  LedJoints() = default;
  /// scene: its imposed joints have coordinates that the device's rig has. Allocates; nothing later does.
  explicit LedJoints(const SceneConfig& scene);

  /// Writes the device's coordinates into the samples of the joints' children. valid: what the device says counts.
  /// A joint is held and let go with its body's handle, or else with the first driven body's.
  void lead(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept;

 private:
  struct Joint {
    std::size_t body = 0;  // the joint's child
    bool driven = false;   // by a handle
    std::size_t num_coordinates = 0;
    std::array<Eigen::Index, 2> device_joints{};
  };

  std::vector<Joint> joints_;
  std::optional<std::size_t> first_driven_;
};

}  // namespace godobject
