// Watches the displayed wrenches for oscillation between their bounds; platform/device/drive_swings.h watches
// the motors' commands.
#pragma once

#include <array>
#include <vector>

#include "hal/rig/swing_watch.h"
#include "platform/scene/scene.h"

namespace godobject {

class WrenchSwings {
 public:
  /// Allocates; the other functions do not. num_wrenches: number of displayed wrenches.
  WrenchSwings(const SceneConfig& scene, std::size_t num_wrenches);

  /// Updates with the wrench of this index in this step. Returns true if it oscillates.
  bool shows(std::size_t index, const Wrench& F) noexcept;
  void reset() noexcept;

 private:
  /// State of one force or torque.
  struct Shown {
    double bound, largest_change;  // bounds of the magnitude, and of its change in a step
    std::array<SwingWatch, 3> watches;
    Vec3 last = Vec3::Zero();

    bool shows(const Vec3& value) noexcept;
  };

  std::vector<Shown> shown_;  // force, torque of each wrench
};

}  // namespace godobject
