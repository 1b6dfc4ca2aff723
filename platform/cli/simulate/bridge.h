// Carries frames both ways between a real bus and a port on a simulated wire.
#pragma once

#include <cstdint>
#include <optional>

#include "platform/linux/bus/bus.h"
#include "sim/bus/can_bus.h"

namespace godobject {

struct BridgeCounters {
  std::uint64_t from_bus = 0;  // frames received from the real bus
  std::uint64_t to_bus = 0;    // frames sent to it
  std::uint64_t refused = 0;   // frames from the bus refused by the port: queue full or bus-off
  std::uint64_t dropped = 0;   // frames for the bus dropped: it was down, or full for `patience_ns`
};

class BusBridge {
 public:
  /// Longest wait of a frame for a bus with a full transmit queue.
  static constexpr Nanoseconds patience_ns = 20'000'000;

  /// bus, port: open; they outlive the bridge.
  BusBridge(LinuxBus& bus, SimCanPort& port) noexcept : bus_(bus), port_(port) {}

  /// Receives the next frame of the real bus, which deliver() passes on.
  [[nodiscard]] bool try_take(CanFrame& frame) noexcept;
  /// Sends the frame on the simulated wire.
  void deliver(const CanFrame& frame) noexcept;
  /// Sends the frames received by the port on the real bus.
  void forward(Nanoseconds now) noexcept;

  const BridgeCounters& counters() const noexcept { return counters_; }
  LinuxBus& bus() const noexcept { return bus_; }

 private:
  LinuxBus& bus_;
  SimCanPort& port_;
  std::optional<CanFrame> waiting_;  // waits while the bus is full
  Nanoseconds t_waiting_ns_ = 0;     // start of the wait
  BridgeCounters counters_;
};

}  // namespace godobject
