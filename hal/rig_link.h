// The host's ends of a rig's buses, and the time on them: simulated, or real.
#pragma once

#include <span>

#include "hal/can_bus.h"

namespace godobject {

/// Every cycle: begin_cycle(), SYNC and commands on the buses, wait() until the answers are in. Between the calls time
/// stands still on a simulated bus and runs on a real one.
class RigLink {
 public:
  virtual ~RigLink() = default;

  /// One per RigParams::buses, open.
  virtual std::span<CanBus* const> buses() noexcept = 0;
  /// The time at which this cycle's SYNC is sent. motion_time: s, where a simulated hand is by then.
  virtual Nanoseconds begin_cycle(double motion_time) noexcept = 0;
  /// Until something may have arrived or it is `until`, whichever is first. Returns the time then.
  virtual Nanoseconds wait(Nanoseconds until) noexcept = 0;
};

}  // namespace godobject
