// Watches what drives are commanded for swinging between their bounds: a hand and a spring that no drive can show stable.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/rig/rig.h"
#include "hal/rig/swing_watch.h"

namespace godobject {

class DriveSwings {
 public:
  /// step: s. Allocates; nothing later does.
  DriveSwings(std::span<const DriveParams> drives, double step) {
    for (const DriveParams& drive : drives)
      watches_.emplace_back(drive.torque_max_Nm, drive.torque_rate_Nm_per_s, step);
  }

  /// The drives' commands in this step, as the rig sent them. The drive that swings, if any.
  std::optional<std::size_t> commands(const Rig& rig, const CommandReport& report) noexcept {
    std::optional<std::size_t> swings;
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      const bool bounded = ((report.torque_limited | report.rate_limited) >> i & 1u) != 0;
      if (watches_[i].update(rig.commanded_torque_Nm(i), bounded)) swings = i;
    }
    return swings;
  }
  void reset() noexcept {
    for (SwingWatch& watch : watches_) watch.reset();
  }

 private:
  std::vector<SwingWatch> watches_;
};

}  // namespace godobject
