// A simulated node on a simulated wire, whatever it speaks.
#pragma once

#include <algorithm>
#include <limits>

#include "sim/bus/can_bus.h"

namespace godobject {

class SimNode {
 public:
  static constexpr Nanoseconds never = std::numeric_limits<Nanoseconds>::max();

  virtual ~SimNode() = default;

  /// Reads what has arrived and runs the timers that are due.
  virtual void poll(Nanoseconds now) noexcept = 0;
  /// When poll() next has something to do; `never` if only a frame can cause it.
  virtual Nanoseconds next_timer() const noexcept = 0;
  virtual std::uint8_t node_id() const noexcept = 0;
  /// Off and on again.
  virtual void power_cycle(Nanoseconds now) noexcept = 0;
  /// The device reports an error, in its own numbers, and does what it does then.
  virtual void trip(std::uint16_t error_code) noexcept = 0;
  /// From now on the node's clock is this many ppm fast: its timers come early.
  virtual void set_clock_error(double ppm, Nanoseconds now) noexcept = 0;
};

/// A simulated drive as the mechanics see it.
class SimMotor {
 public:
  virtual ~SimMotor() = default;
  /// True joint coordinate (rad or m) and its rate, from the plant. NaN: its sensor gives no value.
  virtual void set_joint(double q, double q_dot) noexcept = 0;
  /// Torque at the motor shaft in the motor's own sense; sign and transmission are the plant's business.
  virtual double applied_torque_Nm() const noexcept = 0;
};

/// Runs a wire and the nodes on it up to and including t, each node at the instant something happens to it:
/// answers to a SYNC compete for the wire as they would in reality. The wire must not be past t.
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
