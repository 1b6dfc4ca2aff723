// The host's ends of a rig's buses, and the time on them: simulated, or real.
#pragma once

#include <cstddef>
#include <span>

#include "hal/can/bus.h"

namespace godobject {

/// Called for each frame on bus `bus` of a rig, at its end on the wire or soon after.
struct BusObserver {
  void (*on_frame)(void* context, std::size_t bus, const ReceivedFrame& frame) = nullptr;
  void* context = nullptr;
};

/// Every cycle: begin_cycle(), SYNC on the buses, wait() until the answers are in, commands, end_cycle().
/// Between the calls time stands still on a simulated bus and runs on a real one.
class RigLink {
 public:
  virtual ~RigLink() = default;

  /// One per RigParams::buses, open.
  virtual std::span<CanBus* const> buses() noexcept = 0;
  /// The time at which this cycle's SYNC is sent. motion_time: s, where a simulated hand is by then.
  virtual Nanoseconds begin_cycle(double motion_time) noexcept = 0;
  /// Until something may have arrived or it is `until`, whichever is first. Returns the time then.
  virtual Nanoseconds wait(Nanoseconds until) noexcept = 0;
  /// The cycle's commands have been handed to the buses.
  virtual void end_cycle() noexcept {}
  /// It is told the frames of all buses from now on, own ones included. Not while a cycle runs.
  virtual void set_observer(const BusObserver& observer) noexcept = 0;
};

}  // namespace godobject
