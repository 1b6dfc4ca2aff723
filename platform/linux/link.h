// Buses of a rig on this machine: observed frames, waiting for frames, and latencies of the service.
#pragma once

#include <poll.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include "hal/can/transmit_slots.h"
#include "hal/rig/link.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/cyclic.h"

namespace godobject {

/// A real bus with an observer: time of the last received frame, and all frames in both directions.
/// Forwards all calls. A bus that sees its own frames complete reports them itself, with their time on the
/// wire. For others (an adapter without an echo) they are reported when accepted, with that time.
class WatchedBus final : public CanBus {
 public:
  /// index: index of the bus in its rig. Must not move after setup.
  WatchedBus(std::unique_ptr<LinuxBus> bus, std::size_t index) : bus_(std::move(bus)), index_(index) {}
  WatchedBus(const WatchedBus&) = delete;
  WatchedBus& operator=(const WatchedBus&) = delete;

  [[nodiscard]] bool open() noexcept override { return bus_->open(); }
  void close() noexcept override { bus_->close(); }
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override {
    const SendResult result = bus_->try_send(frame);
    if (result == SendResult::queued && !shows_itself_)
      show({.frame = frame, .t_ns = MonotonicClock{}.now()});
    return result;
  }
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override {
    if (!bus_->try_receive(out)) return false;
    t_received_ns_ = std::max(t_received_ns_, out.t_ns);
    if (!shows_itself_) show(out);
    return true;
  }
  BusState state() const noexcept override { return bus_->state(); }
  BusCounters counters() const noexcept override { return bus_->counters(); }

  LinuxBus& bus() noexcept { return *bus_; }
  const LinuxBus& bus() const noexcept { return *bus_; }
  /// Latest receive stamp; 0 if no frame was received.
  Nanoseconds t_received_ns() const noexcept { return t_received_ns_; }

  void set_observer(const BusObserver& observer) noexcept {
    observer_ = observer;
    shows_itself_ =
        bus_->observe({.on_frame =
                           [](void* context, const ReceivedFrame& frame) noexcept GODOBJECT_NONBLOCKING {
                             static_cast<const WatchedBus*>(context)->show(frame);
                           },
                       .context = this});
  }

 private:
  void show(const ReceivedFrame& frame) const noexcept {
    if (observer_.on_frame) observer_.on_frame(observer_.context, index_, frame);
  }

  std::unique_ptr<LinuxBus> bus_;
  std::size_t index_;
  BusObserver observer_;
  bool shows_itself_ = false;
  Nanoseconds t_received_ns_ = 0;
};

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

inline LinuxLink::LinuxLink(std::vector<std::unique_ptr<LinuxBus>> buses, Nanoseconds period)
    : period_ns_(period) {
  for (std::unique_ptr<LinuxBus>& bus : buses) {
    ends_.push_back(std::make_unique<End>(std::move(bus), ends_.size()));
    ports_.push_back(&ends_.back()->paced);
  }
  polled_.resize(ends_.size());
}

inline Nanoseconds LinuxLink::begin_cycle(double /*motion_time*/) noexcept {
  const Nanoseconds now = clock_.now();
  const Nanoseconds since_last = now - t_cycle_ns_;
  // Whole periods left out are counted by the loop.
  if (since_last < period_ns_ + period_ns_ / 2) timing_.sync_jitter_ns.add(std::abs(since_last - period_ns_));
  t_cycle_ns_ = now;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    ends_[i]->paced.advance_to(now);
    polled_[i] = {.fd = bus(i).descriptor(), .events = POLLIN, .revents = 0};
  }
  return now;
}

inline Nanoseconds LinuxLink::wait(Nanoseconds until) noexcept {
  const Nanoseconds left = until - clock_.now();
  if (left <= 0) return clock_.now();
  const timespec timeout{.tv_sec = left / 1'000'000'000, .tv_nsec = left % 1'000'000'000};
  const int ready = loop::poll(polled_.data(), polled_.size(), timeout);
  // A missing bus is always readable. Reading it once a cycle, without waiting for it, keeps the loop asleep.
  if (ready > 0)
    for (pollfd& bus : polled_)
      if ((bus.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) bus.fd = -1;
  return clock_.now();
}

inline void LinuxLink::end_cycle() noexcept {
  const Nanoseconds t_received = t_received_ns();
  if (t_received > t_cycle_ns_) timing_.added_latency_ns.add(clock_.now() - t_received);
}

inline void LinuxLink::set_observer(const BusObserver& observer) noexcept {
  for (const std::unique_ptr<End>& end : ends_) end->watched.set_observer(observer);
}

inline Nanoseconds LinuxLink::t_received_ns() const noexcept {
  Nanoseconds latest = 0;
  for (const std::unique_ptr<End>& end : ends_) latest = std::max(latest, end->watched.t_received_ns());
  return latest;
}

}  // namespace godobject
