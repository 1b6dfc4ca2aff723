#include "sim/node/odrive.h"

#include "sim/node/encoder.h"

namespace godobject {

namespace {

// Phase of the cyclic messages per node id: drives have independent clocks, so their messages do not
// coincide.
constexpr Nanoseconds phase_step_ns = 1'370'000;

}  // namespace

void SimOdrive::poll(Nanoseconds now) noexcept {
  for (ReceivedFrame received; bus_.try_receive(received);) on_frame(received.frame, now);
  if (now >= watchdog_deadline()) fail(odrive::error_watchdog);
  for (; t_heartbeat_ns_ <= now; t_heartbeat_ns_ += period_ns(odrive::heartbeat_period_s)) {
    constexpr std::uint8_t trajectory_done = 0x80;
    const std::uint8_t last = quirks_.firmware_0_5 ? trajectory_done : std::uint8_t{0};
    send(odrive::make_heartbeat(node_id(), {.error = error_,
                                            .axis_state = static_cast<std::uint8_t>(axis_state_),
                                            .flags = {motor_error_, 0, last}}));
  }
  for (; t_torques_ns_ <= now; t_torques_ns_ += period_ns(odrive::torques_period_s)) {
    const auto torque_Nm = static_cast<float>(applied_torque_Nm());
    send(odrive::make_torques(node_id(), {.target_Nm = torque_Nm_, .estimate_Nm = torque_Nm}));
  }
}

Nanoseconds SimOdrive::next_timer() const noexcept {
  return std::min({t_heartbeat_ns_, t_torques_ns_, watchdog_deadline()});
}

Nanoseconds SimOdrive::watchdog_deadline() const noexcept {
  const bool enabled = params_.watchdog == DriveWatchdog::drive;  // axis.config.enable_watchdog
  return enabled && closed_loop() ? t_fed_ns_ + period_ns(1e-3 * params_.watchdog_ms) : never;
}

void SimOdrive::power_cycle(Nanoseconds now) noexcept {
  axis_state_ = odrive::axis_idle;
  error_ = 0;
  motor_error_ = quirks_.motor_error;
  torque_mode_ = false;
  torque_Nm_ = 0;
  t_heartbeat_ns_ = now + phase_step_ns * node_id();
  t_torques_ns_ = t_heartbeat_ns_ + phase_step_ns;
}

void SimOdrive::set_clock_error(double ppm, Nanoseconds) noexcept { clock_rate_ = 1 + 1e-6 * ppm; }

Nanoseconds SimOdrive::period_ns(double period_s) const noexcept {
  return std::llround(1e9 * period_s / clock_rate_);
}

double SimOdrive::applied_torque_Nm() const noexcept {
  if (!closed_loop() || !torque_mode_) return 0;
  return std::clamp(static_cast<double>(torque_Nm_), -params_.torque_max_Nm, params_.torque_max_Nm);
}

void SimOdrive::on_frame(const CanFrame& frame, Nanoseconds now) noexcept {
  const auto is = [&](odrive::Command command) {
    return !frame.extended && !frame.fd && frame.id == odrive::frame_id(node_id(), command);
  };
  ByteReader bytes(frame.bytes());
  std::uint32_t first = 0, second = 0;
  if (frame.remote) {
    if (is(odrive::Command::encoder_estimates)) send_estimates();
  } else if (is(odrive::Command::set_input_torque)) {
    float torque_Nm = 0;
    if (!bytes.get(torque_Nm).ok() || !std::isfinite(torque_Nm)) return;
    torque_Nm_ = torque_Nm;
    t_fed_ns_ = now;
  } else if (is(odrive::Command::set_controller_mode)) {
    if (!bytes.get(first).get(second).ok()) return;
    torque_mode_ = first == odrive::control_torque && second == odrive::input_pass_through;
  } else if (is(odrive::Command::set_axis_state)) {
    if (!bytes.get(first).ok() || error_ != 0 || motor_error_ != 0) return;
    if (first == odrive::axis_closed_loop && !closed_loop()) {
      torque_Nm_ = 0;
      t_fed_ns_ = now;
      ++times_enabled_;
      if (quirks_.error_in_closed_loop != 0) return fail(quirks_.error_in_closed_loop);
    }
    axis_state_ = first;
  } else if (is(odrive::Command::clear_errors)) {
    error_ = 0;
    motor_error_ = 0;
  } else if (is(odrive::Command::estop)) {
    fail(odrive::error_estop);
  }
}

void SimOdrive::fail(std::uint32_t error) noexcept {
  error_ |= error;
  axis_state_ = odrive::axis_idle;
  torque_Nm_ = 0;
}

void SimOdrive::send_estimates() noexcept {
  const Calibration& c = params_.calibration;
  const double counts = c.sign * (q_ - c.home) * c.counts_per_unit + static_cast<double>(c.offset_counts);
  send(odrive::make_encoder_estimates(
      node_id(), {.position_rev = static_cast<float>(counts / counts_per_motor_turn),
                  .velocity_rev_per_s =
                      static_cast<float>(c.sign * q_dot_ * c.counts_per_unit / counts_per_motor_turn)}));
}

}  // namespace godobject
