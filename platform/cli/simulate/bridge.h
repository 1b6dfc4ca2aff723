// Carries frames between a real bus and a port on a simulated wire, both ways.
#pragma once

#include <cstdint>
#include <optional>

#include "platform/linux/bus/bus.h"
#include "sim/bus/can_bus.h"

namespace godobject {

struct BridgeCounters {
  std::uint64_t from_bus = 0;  // frames that came from the real bus
  std::uint64_t to_bus = 0;    // frames that it took
  std::uint64_t refused = 0;   // of those from the bus: the port's queue was full, or it was bus-off
  std::uint64_t dropped = 0;   // of those for the bus: it was down, or took none for `patience_ns`
};

class BusBridge {
 public:
  /// So long a frame waits for a bus whose transmit queue is full.
  static constexpr Nanoseconds patience_ns = 20'000'000;

  /// Both open, both outliving the bridge.
  BusBridge(LinuxBus& bus, SimCanPort& port) noexcept : bus_(bus), port_(port) {}

  /// The next frame of the real bus; it is still to be passed on by deliver().
  [[nodiscard]] bool try_take(CanFrame& frame) noexcept;
  /// Onto the simulated wire.
  void deliver(const CanFrame& frame) noexcept;
  /// What the port has received goes out on the real bus.
  void forward(Nanoseconds now) noexcept;

  const BridgeCounters& counters() const noexcept { return counters_; }
  LinuxBus& bus() const noexcept { return bus_; }

 private:
  LinuxBus& bus_;
  SimCanPort& port_;
  std::optional<CanFrame> waiting_;  // the bus was full
  Nanoseconds t_waiting_ns_ = 0;     // since when
  BridgeCounters counters_;
};

}  // namespace godobject
