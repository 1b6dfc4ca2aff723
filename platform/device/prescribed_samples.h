// Samples of the prescribed joints of the scene, which follow the device's joints of the same names.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "platform/engine/engine.h"
#include "platform/scene/scene.h"

namespace godobject {

class PrescribedSamples {
 public:
  PrescribedSamples() = default;
  /// Allocates; the other functions do not. scene: each coordinate of its prescribed joints must be a joint
  /// of the device's rig.
  explicit PrescribedSamples(const SceneConfig& scene);

  /// Writes the device's coordinates into the samples of the joints' children. valid: true if the device's
  /// sample is valid.
  /// A joint is engaged with its body's handle, or else with the first driven body's.
  void write(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept;

 private:
  struct Joint {
    std::size_t body = 0;  // the joint's child
    bool driven = false;   // true if a handle drives the body
    std::size_t num_coordinates = 0;
    std::array<Eigen::Index, 2> device_joints{};
  };

  std::vector<Joint> joints_;
  std::optional<std::size_t> first_driven_;
};

}  // namespace godobject
