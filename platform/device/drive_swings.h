// Watches drive commands for oscillation between their bounds, as caused by feedback that the drives cannot
// display in a stable way.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/rig/rig.h"
#include "hal/rig/swing_watch.h"

namespace godobject {

class DriveSwings {
 public:
  /// Allocates; the other functions do not. step: period, s.
  DriveSwings(std::span<const DriveParams> drives, double step) {
    for (const DriveParams& drive : drives)
      watches_.emplace_back(drive.torque_max_Nm, drive.torque_rate_Nm_per_s, step);
  }

  /// Updates with the commands that the rig sent in this step. Returns the oscillating drive, if any.
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
