// Drives without CANopen at the other end of the host's bus: commands, answers, heartbeats and watchdog.
#pragma once

#include <functional>

#include "hal/drive/moteus.h"
#include "hal/drive/odrive.h"

namespace godobject::test {

/// Sends a frame to the host.
using SendFrame = std::function<void(const CanFrame&)>;

/// A drive of one protocol. Its torque is 0 unless it is enabled.
class ScriptedDrive {
 public:
  virtual ~ScriptedDrive() = default;

  virtual void receive_from_host(const CanFrame& frame) = 0;
  /// Answers the requests of this cycle.
  virtual void answer(const SendFrame& send) = 0;
  virtual void send_heartbeat(const SendFrame& send) = 0;
  virtual bool is_enabled() const = 0;
  virtual bool has_failed() const = 0;
  /// Fails with its own error code.
  virtual void fail() = 0;
  /// Disables itself without an error.
  virtual void disable() = 0;
  /// Acts as its watchdog does after too long a time without a command.
  virtual void time_out() = 0;

  void power(bool on) {
    if (powered == on) return;
    powered = on;
    restart();
    torque_Nm = 0;
  }
  /// Ends a cycle: the watchdog.
  void end_cycle(int watchdog_cycles) {
    if (cycles_without_command++ > watchdog_cycles && is_enabled()) time_out();
    if (!is_enabled() || !powered) torque_Nm = 0;
  }

  bool powered = true;
  double torque_Nm = 0;
  double position_rev = 0;
  int cycles_without_command = 0;

 protected:
  virtual void restart() = 0;
};

class ScriptedOdrive final : public ScriptedDrive {
 public:
  explicit ScriptedOdrive(std::uint8_t node) : node_(node) {}

  void receive_from_host(const CanFrame& frame) override {
    const auto is = [&](odrive::Command command) { return frame.id == odrive::frame_id(node_, command); };
    if (!powered) return;
    if (frame.remote) {
      requested_ = requested_ || is(odrive::Command::encoder_estimates);
    } else if (is(odrive::Command::set_input_torque)) {
      float torque = 0;
      ByteReader(frame.bytes()).get(torque);
      cycles_without_command = 0;
      torque_Nm = is_enabled() ? static_cast<double>(torque) : 0;
    } else if (is(odrive::Command::clear_errors)) {
      heartbeat.error = 0;
    } else if (is(odrive::Command::set_axis_state)) {
      std::uint32_t state = 0;
      ByteReader(frame.bytes()).get(state);
      const bool may = state != odrive::axis_closed_loop || heartbeat.error == 0;
      heartbeat.axis_state = static_cast<std::uint8_t>(may ? state : odrive::axis_idle);
      if (!is_enabled()) torque_Nm = 0;
    }
  }
  void answer(const SendFrame& send) override {
    if (std::exchange(requested_, false) && powered)
      send(odrive::make_encoder_estimates(node_, {.position_rev = static_cast<float>(position_rev)}));
  }
  void send_heartbeat(const SendFrame& send) override {
    if (powered) send(odrive::make_heartbeat(node_, heartbeat));
  }
  bool is_enabled() const override { return heartbeat.axis_state == odrive::axis_closed_loop; }
  bool has_failed() const override { return heartbeat.error != 0; }
  void fail() override { stop_with(odrive::error_estop); }
  void disable() override { heartbeat.axis_state = odrive::axis_idle; }
  void time_out() override { stop_with(odrive::error_watchdog); }

  odrive::Heartbeat heartbeat{.axis_state = odrive::axis_idle};

 private:
  void restart() override {
    heartbeat = {.axis_state = odrive::axis_idle};
    requested_ = false;
  }
  void stop_with(std::uint32_t error) { heartbeat = {.error = error, .axis_state = odrive::axis_idle}; }

  std::uint8_t node_;
  bool requested_ = false;
};

class ScriptedMoteus final : public ScriptedDrive {
 public:
  explicit ScriptedMoteus(std::uint8_t node) : node_(node) {}

  void receive_from_host(const CanFrame& frame) override {
    const bool is_request = frame.id == moteus::request_id(node_);
    if (!powered || (!is_request && frame.id != moteus::command_id(node_))) return;
    requested_ = requested_ || is_request;
    moteus::SubframeReader reader(frame.bytes());
    for (moteus::Subframe subframe; reader.next(subframe);) {
      if (subframe.kind != moteus::SubframeKind::write) continue;
      for (std::uint32_t i = 0; i < subframe.count; ++i) write(subframe.first + i, subframe.value(i));
    }
  }
  void answer(const SendFrame& send) override {
    if (std::exchange(requested_, false) && powered)
      send(moteus::make_reply(node_, {.mode = mode, .position_rev = position_rev, .fault = fault}));
  }
  void send_heartbeat(const SendFrame&) override {}
  bool is_enabled() const override { return mode == moteus::mode_position; }
  bool has_failed() const override { return mode == moteus::mode_fault || mode == moteus::mode_timeout; }
  void fail() override {
    mode = moteus::mode_fault;
    fault = 33;
  }
  void disable() override { mode = moteus::mode_stopped; }
  void time_out() override { mode = moteus::mode_timeout; }

  int mode = moteus::mode_stopped, fault = 0;

 private:
  void restart() override {
    mode = moteus::mode_stopped;
    fault = 0;
    requested_ = false;
  }
  void write(std::uint32_t reg, double value) {
    const bool stops = value == moteus::mode_stopped;
    if (reg == moteus::mode && (stops || !has_failed())) {
      mode = stops ? moteus::mode_stopped : moteus::mode_position;
      if (stops) torque_Nm = 0;
      if (stops) fault = 0;
      cycles_without_command = 0;
    }
    if (reg == moteus::feedforward_torque) torque_Nm = is_enabled() ? value : 0;
  }

  std::uint8_t node_;
  bool requested_ = false;
};

}  // namespace godobject::test
