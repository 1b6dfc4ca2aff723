// The buses of a rig on this machine: how the loop waits for them, and how promptly it serves them.
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
  Histogram
      added_latency_ns;      // from the stamp of the last frame received in a cycle to its commands' sending
  Histogram sync_jitter_ns;  // of the time between the SYNCs of consecutive cycles
};

/// Its time is CLOCK_MONOTONIC, that of the receive stamps.
class LinuxLink final : public RigLink {
 public:
  /// One per RigParams::buses, in their order. period: of the cycles, ns. Allocates; nothing later does.
  LinuxLink(std::vector<std::unique_ptr<LinuxBus>> buses, Nanoseconds period);

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override;
  Nanoseconds wait(Nanoseconds until) noexcept override;
  void end_cycle() noexcept override;
  void set_observer(const BusObserver& observer) noexcept override;

  std::size_t num_buses() const noexcept { return ends_.size(); }
  LinuxBus& bus(std::size_t index) noexcept { return ends_[index]->watched.bus(); }
  /// At set-up: frames with this standard identifier are worth sending for so long after they were made, and
  /// only the newest of them. False: PacedCanBus has no slot left.
  [[nodiscard]] bool add_slot(std::size_t bus, std::uint32_t id, Nanoseconds lifetime) noexcept {
    return ends_[bus]->paced.add_slot(id, lifetime);
  }
  const LinkTiming& timing() const noexcept { return timing_; }

 private:
  /// What the rig sends goes through both; what a full bus does not take waits in the second.
  struct End {
    End(std::unique_ptr<LinuxBus> bus, std::size_t index) : watched(std::move(bus), index), paced(watched) {}
    WatchedBus watched;
    PacedCanBus paced;
  };

  Nanoseconds t_received_ns() const noexcept;

  std::vector<std::unique_ptr<End>> ends_;
  std::vector<CanBus*> ports_;
  std::vector<pollfd> polled_;  // one per bus; a negative descriptor is not waited for
  Nanoseconds period_ns_;
  Nanoseconds t_cycle_ns_ = 0;
  LinkTiming timing_;
  MonotonicClock clock_;
};

}  // namespace godobject
