// Watches the wrenches that a run shows to the hand for swinging between their bounds; platform/device/drive_swings.h does it
// for motors' commands.
#pragma once

#include <array>
#include <vector>

#include "hal/rig/swing_watch.h"
#include "platform/scene/scene.h"

namespace godobject {

class WrenchSwings {
 public:
  /// num_wrenches: that are shown. Allocates; nothing later does.
  WrenchSwings(const SceneConfig& scene, std::size_t num_wrenches);

  /// The wrench of this index in this step. True: it swings.
  bool shows(std::size_t index, const Wrench& F) noexcept;
  void reset() noexcept;

 private:
  /// One of force and torque.
  struct Shown {
    double bound, largest_change;  // of the length, and that in a step
    std::array<SwingWatch, 3> watches;
    Vec3 last = Vec3::Zero();

    bool shows(const Vec3& value) noexcept;
  };

  std::vector<Shown> shown_;  // force, torque of each wrench
};

}  // namespace godobject
