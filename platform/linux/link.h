// Buses of a rig on this machine: waiting for frames, and latencies of the service.
#pragma once

#include <poll.h>

#include <array>
#include <memory>
#include <vector>

#include "hal/can/transmit_slots.h"
#include "hal/rig/link.h"
#include "platform/linux/bus/watched.h"
#include "platform/rt/histogram.h"

namespace godobject {

struct LinkTiming {
  // time from the stamp of the last received frame of a cycle to the sending of its commands
  Histogram added_latency_ns;
  Histogram sync_jitter_ns;  // deviation of the time between the SYNCs of consecutive cycles
};

/// Link on real buses. Its clock is CLOCK_MONOTONIC, as that of the receive stamps.
class LinuxLink final : public RigLink {
 public:
  /// Allocates; the other functions do not. buses: one per RigParams::buses, in their order. period: period
  /// of the cycles, ns.
  LinuxLink(std::vector<std::unique_ptr<LinuxBus>> buses, Nanoseconds period);

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override;
  Nanoseconds wait(Nanoseconds until) noexcept override;
  void end_cycle() noexcept override;
  void set_observer(const BusObserver& observer) noexcept override;

  std::size_t num_buses() const noexcept { return ends_.size(); }
  LinuxBus& bus(std::size_t index) noexcept { return ends_[index]->watched.bus(); }
  /// Reserves a slot for frames with this standard identifier; only the newest frame is kept, for `lifetime`
  /// ns. For setup. Returns false if PacedCanBus has no slot left.
  [[nodiscard]] bool add_slot(std::size_t bus, std::uint32_t id, Nanoseconds lifetime) noexcept {
    return ends_[bus]->paced.add_slot(id, lifetime);
  }
  const LinkTiming& timing() const noexcept { return timing_; }

 private:
  /// Frames of the rig pass through both members; `paced` holds those that a full bus refuses.
  struct End {
    End(std::unique_ptr<LinuxBus> bus, std::size_t index) : watched(std::move(bus), index), paced(watched) {}
    WatchedBus watched;
    PacedCanBus paced;
  };

  Nanoseconds t_received_ns() const noexcept;

  std::vector<std::unique_ptr<End>> ends_;
  std::vector<CanBus*> ports_;
  std::vector<pollfd> polled_;  // one per bus; negative descriptors are ignored
  Nanoseconds period_ns_;
  Nanoseconds t_cycle_ns_ = 0;
  LinkTiming timing_;
  MonotonicClock clock_;
};

}  // namespace godobject
