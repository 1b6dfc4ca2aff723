// Watches everything a run shows to the hand for swinging between its bounds: each wrench, each motor's command.
#pragma once

#include <optional>
#include <vector>

#include "hal/rig/rig.h"
#include "hal/rig/swing_watch.h"
#include "platform/scene/scene.h"

namespace godobject {

class ForceSwings {
 public:
  /// num_wrenches: that are shown. Allocates; nothing later does.
  ForceSwings(const SceneConfig& scene, std::size_t num_wrenches);

  /// The wrench of this index in this step. True: it swings.
  bool shows(std::size_t index, const Wrench& F) noexcept;
  /// The drives' commands in this step, as the rig sent them. The drive that swings, if any.
  std::optional<std::size_t> commands(const Rig& rig, const CommandReport& report) noexcept;
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
  std::vector<SwingWatch> drives_;
};

}  // namespace godobject
