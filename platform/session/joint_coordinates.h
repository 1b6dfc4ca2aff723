// Coordinates of a scene's joints, computed from the poses of its bodies, for records.
#pragma once

#include <span>
#include <vector>

#include "platform/engine/engine.h"

namespace godobject {

class JointCoordinatesOf {
 public:
  explicit JointCoordinatesOf(const SceneConfig& scene);

  /// Number of coordinates of all joints: see num_coordinates().
  std::size_t size() const noexcept { return size_; }
  /// Writes the coordinates of all joints. Angles are unwrapped: within half a turn of the previous ones.
  /// Real-time.
  /// bodies: all bodies of the scene. q: size() numbers; on entry the previous coordinates.
  void read(std::span<const BodyView> bodies, std::span<double> q) const noexcept;

 private:
  struct Joint {
    JointParams params;
    std::size_t child = 0;
  };
  std::vector<Joint> joints_;
  std::size_t size_ = 0;
};

}  // namespace godobject
