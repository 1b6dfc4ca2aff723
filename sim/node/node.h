// A simulated node on a simulated wire, of any protocol.
#pragma once

#include <algorithm>
#include <limits>

#include "sim/bus/can_bus.h"

namespace godobject {

class SimNode {
 public:
  static constexpr Nanoseconds never = std::numeric_limits<Nanoseconds>::max();

  virtual ~SimNode() = default;

  /// Processes received frames and due timers.
  virtual void poll(Nanoseconds now) noexcept = 0;
  /// Returns the next time at which poll() has work; `never` if only a frame can cause it.
  virtual Nanoseconds next_timer() const noexcept = 0;
  virtual std::uint8_t node_id() const noexcept = 0;
  /// Power-cycles the node.
  virtual void power_cycle(Nanoseconds now) noexcept = 0;
  /// Reports a device-specific error and reacts as the device does.
  virtual void trip(std::uint16_t error_code) noexcept = 0;
  /// Sets the clock error, ppm; positive: the clock is fast and timers expire early.
  virtual void set_clock_error(double ppm, Nanoseconds now) noexcept = 0;
};

/// Interface of a simulated drive to the mechanics.
class SimMotor {
 public:
  virtual ~SimMotor() = default;
  /// Sets the true joint coordinate (rad or m) and its rate, from the plant. NaN: its sensor has no value.
  virtual void set_joint(double q, double q_dot) noexcept = 0;
  /// Returns the torque at the motor shaft, N m, with the motor's sign; the plant applies sign and
  /// transmission.
  virtual double applied_torque_Nm() const noexcept = 0;
};

/// Runs a wire and its nodes up to and including t_ns, each node at the instant of its next event. Answers to
/// a SYNC thus compete for the wire as in reality. The wire's time must not be past t_ns.
template <class Nodes>  // a range of pointers to SimNode
void advance(SimCanWire& wire, const Nodes& nodes, Nanoseconds t_ns) noexcept {
  for (;;) {
    for (auto* node : nodes) node->poll(wire.now());
    Nanoseconds t_next_ns = wire.next_event().value_or(SimNode::never);
    for (const auto* node : nodes) t_next_ns = std::min(t_next_ns, node->next_timer());
    if (t_next_ns > t_ns) break;
    wire.advance_to(t_next_ns);
  }
  wire.advance_to(t_ns);
}

}  // namespace godobject
