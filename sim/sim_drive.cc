#include "sim/sim_drive.h"

#include <algorithm>

#include "sim/sim_encoder.h"

namespace godobject {

using cia402::DriveState;

SimDrive::SimDrive(CanBus& bus, const SimDriveParams& params) noexcept
    : SimCanopenNode(bus, params.drive.node_id, params.heartbeat_period_ns), params_(params) {}

double SimDrive::applied_torque_Nm() const noexcept {
  if (state_ != DriveState::operation_enabled) return 0;
  const double target_Nm =
      cia402::torque_from_per_mille(active_.target_torque_per_mille, params_.drive.torque_rated_Nm);
  return std::clamp(target_Nm, -params_.drive.torque_max_Nm, params_.drive.torque_max_Nm);
}

void SimDrive::trip(std::uint16_t error_code) noexcept {
  state_ = DriveState::fault;
  error_code_ = error_code;
  send_emergency();
}

void SimDrive::on_sync(Nanoseconds) noexcept {
  if (++syncs_since_status_ >= params_.drive.status_every_nth_sync) {
    syncs_since_status_ = 0;
    send_status();
  }
  if (!has_received_) return;
  has_received_ = false;
  const std::uint16_t last_controlword = active_.controlword;
  active_ = received_;
  if ((active_.controlword & ~last_controlword & cia402::fault_reset_bit) != 0) reset_fault();
  else obey(active_.controlword);
}

void SimDrive::on_pdo(const CanFrame& frame, Nanoseconds now) noexcept {
  switch (cia402::parse_command(frame, node_id(), received_)) {
    case ParseResult::ok:
      has_received_ = true;
      t_received_ns_ = now;
      break;
    case ParseResult::too_short:
      send(canopen::make_emergency({.node = node_id(), .error_code = canopen::emcy_pdo_too_short}));
      break;
    case ParseResult::too_long:
      send(canopen::make_emergency({.node = node_id(), .error_code = canopen::emcy_pdo_too_long}));
      break;
    case ParseResult::other_message:
    case ParseResult::bad_value: break;
  }
}

void SimDrive::on_nmt_state(Nanoseconds now) noexcept {
  has_received_ = false;
  active_ = {};
  syncs_since_status_ = 0;
  t_event_ns_ = is_operational() && params_.event_period_ns > 0 ? now + params_.event_period_ns : never;
  if (nmt_state() == canopen::NmtState::boot_up) {
    state_ = DriveState::not_ready_to_switch_on;
    error_code_ = canopen::emcy_no_error;
  } else if (state_ != DriveState::fault) {
    state_ = DriveState::switch_on_disabled;
  }
}

void SimDrive::on_tick(Nanoseconds now) noexcept {
  const bool commands_late = now >= t_received_ns_ + params_.rpdo_timeout_ns;
  if (power_stage_works() && commands_late) trip(canopen::emcy_rpdo_timeout);
  while (t_event_ns_ <= now) {
    send_event();
    t_event_ns_ += params_.event_period_ns;
  }
}

Nanoseconds SimDrive::device_timer() const noexcept {
  return power_stage_works() ? std::min(t_event_ns_, t_received_ns_ + params_.rpdo_timeout_ns) : t_event_ns_;
}

void SimDrive::send_status() noexcept {
  const double torque_per_mille = 1000 * applied_torque_Nm() / params_.drive.torque_rated_Nm;
  const std::uint32_t counts = counts_at(q_, params_.drive.calibration);
  send(cia402::make_status(node_id(),
                           {.statusword = statusword(),
                            .position_counts = static_cast<std::int32_t>(counts),
                            .actual_torque_per_mille = saturate_to<std::int16_t>(torque_per_mille)}));
}

void SimDrive::send_event() noexcept {
  const Calibration& calibration = params_.drive.calibration;
  const double velocity = calibration.sign * q_dot_ * calibration.counts_per_unit;
  send(cia402::make_event(node_id(), {.velocity_counts_per_s = saturate_to<std::int32_t>(velocity),
                                      .mode = cia402::mode_cyclic_synchronous_torque,
                                      .error_code = error_code_}));
}

// Transitions of the CiA 402 state machine; commands by their masks over bits 7, 3, 2, 1, 0.
void SimDrive::obey(std::uint16_t controlword) noexcept {
  const bool disable_voltage = (controlword & 0x82u) == 0x00;
  const bool quick_stop = (controlword & 0x86u) == 0x02;
  const bool shutdown = (controlword & 0x87u) == 0x06;
  const bool switch_on = (controlword & 0x87u) == 0x07;  // bit 3 is the next transition's
  const bool disable_operation = (controlword & 0x8Fu) == 0x07;
  const bool enable_operation = (controlword & 0x8Fu) == 0x0F;

  switch (state_) {
    case DriveState::switch_on_disabled:
      if (shutdown) state_ = DriveState::ready_to_switch_on;
      break;
    case DriveState::ready_to_switch_on:
      if (switch_on) state_ = DriveState::switched_on;
      else if (disable_voltage || quick_stop) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::switched_on:
      if (enable_operation) state_ = DriveState::operation_enabled;
      else if (shutdown) state_ = DriveState::ready_to_switch_on;
      else if (disable_voltage || quick_stop) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::operation_enabled:
      if (disable_operation) state_ = DriveState::switched_on;
      else if (shutdown) state_ = DriveState::ready_to_switch_on;
      else if (quick_stop) state_ = DriveState::quick_stop_active;
      else if (disable_voltage) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::quick_stop_active:
      if (disable_voltage) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::not_ready_to_switch_on:
    case DriveState::fault_reaction_active:
    case DriveState::fault:
    case DriveState::unknown: break;
  }
}

void SimDrive::reset_fault() noexcept {
  if (state_ != DriveState::fault) return;
  state_ = DriveState::switch_on_disabled;
  error_code_ = canopen::emcy_no_error;
  send_emergency();
}

void SimDrive::send_emergency() noexcept {
  // Error register 1001h: generic error, and communication error for the 8xxxh codes.
  const bool communication = (error_code_ >> 12) == 0x8;
  const std::uint8_t error_register = error_code_ == 0 ? 0x00 : communication ? 0x11 : 0x01;
  send(canopen::make_emergency(
      {.node = node_id(), .error_code = error_code_, .error_register = error_register}));
}

std::uint16_t SimDrive::statusword() const noexcept {
  const double target_per_mille = active_.target_torque_per_mille;
  const bool enabled = state_ == DriveState::operation_enabled;
  const bool limited = enabled && std::abs(target_per_mille) > max_per_mille();
  unsigned word = cia402::encode_state(state_) | cia402::status_voltage_enabled | cia402::status_remote;
  if (limited) word |= cia402::status_internal_limit;
  if (enabled) word |= cia402::status_follows_command;
  return static_cast<std::uint16_t>(word);
}

bool SimDrive::power_stage_works() const noexcept {
  return state_ == DriveState::operation_enabled || state_ == DriveState::quick_stop_active;
}

double SimDrive::max_per_mille() const noexcept {
  return 1000 * params_.drive.torque_max_Nm / params_.drive.torque_rated_Nm;
}

}  // namespace godobject
