// Host interfaces of a rig's buses and their clock: simulated or real.
#pragma once

#include <cstddef>
#include <span>

#include "core/nonblocking.h"
#include "hal/can/bus.h"

namespace godobject {

/// Callback for each frame on bus `bus` of a rig, at its end on the wire or soon after.
struct BusObserver {
  void (*on_frame)(void* context, std::size_t bus,
                   const ReceivedFrame& frame) GODOBJECT_NONBLOCKING = nullptr;
  void* context = nullptr;
};

/// Each cycle: begin_cycle(), SYNC on the buses, wait() until the answers are in, commands, end_cycle().
/// Between calls, time stands still on a simulated bus and runs on a real one.
class RigLink {
 public:
  virtual ~RigLink() = default;

  /// Returns one bus per RigParams::buses, open.
  virtual std::span<CanBus* const> buses() noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the time at which this cycle's SYNC is sent, ns. motion_time: time of the simulated hand's
  /// motion, s.
  virtual Nanoseconds begin_cycle(double motion_time) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Waits until a frame may have arrived or until time `until`, the earlier. Returns the time then, ns.
  virtual Nanoseconds wait(Nanoseconds until) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Called after the cycle's commands were passed to the buses.
  virtual void end_cycle() noexcept GODOBJECT_NONBLOCKING {}
  /// Reports the frames of all buses, including own ones, to `observer` from now on. Not during a cycle.
  virtual void set_observer(const BusObserver& observer) noexcept = 0;
};

}  // namespace godobject
