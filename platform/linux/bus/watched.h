// A real bus with an observer: time of the last received frame, and all frames in both directions.
#pragma once

#include <algorithm>

#include "hal/rig/link.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/clock.h"

namespace godobject {

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
    shows_itself_ = bus_->observe(
        {.on_frame = [](void* context,
                        const ReceivedFrame& frame) { static_cast<const WatchedBus*>(context)->show(frame); },
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

}  // namespace godobject
