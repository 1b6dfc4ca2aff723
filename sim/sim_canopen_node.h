// A simulated CANopen slave: boot-up, network management, heartbeat and SYNC. Devices derive from it.
#pragma once

#include <limits>
#include <span>

#include "hal/canopen.h"
#include "sim/sim_can_bus.h"

namespace godobject {

/// Sends its boot-up message with the first tick after power-up or a reset and is then pre-operational.
/// PDOs are exchanged in the NMT state operational only. A message that the bus refuses is not repeated, the
/// bus counts it; only the boot-up message waits for a bus that takes it.
class SimCanopenNode {
 public:
  static constexpr Nanoseconds never = std::numeric_limits<Nanoseconds>::max();

  /// bus: must outlive the node and be opened by the caller. heartbeat_period_ns 0: no heartbeat.
  SimCanopenNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns) noexcept
      : bus_(bus), node_id_(node_id), heartbeat_period_ns_(heartbeat_period_ns) {}
  virtual ~SimCanopenNode() = default;
  SimCanopenNode(const SimCanopenNode&) = delete;
  SimCanopenNode& operator=(const SimCanopenNode&) = delete;

  /// Reads what has arrived and runs the timers that are due.
  void poll(Nanoseconds now) noexcept;
  void on_frame(const CanFrame& frame, Nanoseconds now) noexcept;
  void tick(Nanoseconds now) noexcept;
  /// When poll() next has something to do; `never` if only a frame can cause it.
  Nanoseconds next_timer() const noexcept;

  /// The device reports an error: EMCY with this code. What else it does is the device's.
  virtual void trip(std::uint16_t error_code) noexcept {
    send(canopen::make_emergency({.node = node_id_, .error_code = error_code, .error_register = 0x01}));
  }
  /// From now on the node's clock is this many ppm fast: its heartbeat and timers come early.
  void set_clock_error(double ppm, Nanoseconds now) noexcept;

  std::uint8_t node_id() const noexcept { return node_id_; }
  canopen::NmtState nmt_state() const noexcept { return nmt_state_; }

 protected:
  void send(const CanFrame& frame) noexcept { static_cast<void>(bus_.try_send(frame)); }
  bool is_operational() const noexcept { return nmt_state_ == canopen::NmtState::operational; }

 private:
  virtual void on_sync(Nanoseconds now) noexcept = 0;            // in operational
  virtual void on_pdo(const CanFrame&, Nanoseconds) noexcept {}  // in operational: any other frame
  virtual void on_nmt_state(Nanoseconds) noexcept {}             // the state has just changed
  virtual void on_tick(Nanoseconds) noexcept {}
  virtual Nanoseconds device_timer() const noexcept { return never; }

  Nanoseconds local_time(Nanoseconds now) const noexcept;
  Nanoseconds bus_time(Nanoseconds local) const noexcept;
  void on_nmt(canopen::NmtCommand command, Nanoseconds now) noexcept;
  void enter(canopen::NmtState state, Nanoseconds now) noexcept;
  void boot(Nanoseconds now) noexcept;

  CanBus& bus_;
  std::uint8_t node_id_;
  canopen::NmtState nmt_state_ = canopen::NmtState::boot_up;
  Nanoseconds heartbeat_period_ns_;
  Nanoseconds t_heartbeat_ns_ = never;
  // The node's clock: it ran at the bus's time until it showed local_origin_ns_ at origin_ns_.
  double clock_rate_ = 1;
  Nanoseconds origin_ns_ = 0, local_origin_ns_ = 0;
};

/// Runs a wire and the nodes on it up to and including t, each node at the instant something happens to it:
/// answers to a SYNC compete for the wire as they would in reality. The wire must not be past t.
void advance(SimCanWire& wire, std::span<SimCanopenNode* const> nodes, Nanoseconds t_ns) noexcept;

}  // namespace godobject
