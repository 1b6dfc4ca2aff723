#include "sim/node/drive.h"

#include <algorithm>

#include "sim/node/encoder.h"

namespace godobject {

using cia402::DriveState;

namespace {

constexpr std::uint32_t device_type_402 = 0x0002'0192;  // servo drive
constexpr std::uint16_t emcy_heartbeat_lost = 0x8130;

std::uint16_t to_ms(Nanoseconds t_ns) noexcept { return static_cast<std::uint16_t>(t_ns / 1'000'000); }

// Duration of a homing and a quick stop: longer than a period of the usual SYNC, so that a status shows them.
constexpr Nanoseconds manoeuvre_duration_ns = 1'500'000;

constexpr std::uint32_t supported_modes = 0x100 | 0x80 | 0x20;  // CSV, CSP, homing; the torque mode is added

// Servo gains in CSP and CSV, as shares of torque_max_Nm: a simulated device has little inertia.
constexpr double servo_stiffness_per_rad = 1;
constexpr double servo_damping_s_per_rad = 0.01;

constexpr std::uint32_t mode_bit(std::int64_t mode) noexcept {
  return mode >= 1 && mode <= 32 ? 1u << (mode - 1) : 0u;
}

}  // namespace

SimDrive::SimDrive(CanBus& bus, const SimDriveParams& params)
    : SimCanopenNode(bus, params.drive.node_id,
                     params.defaults == SimDefaults::rig ? params.heartbeat_period_ns : 0),
      params_(params) {
  identify(device_type_402, "simulated CiA 402 drive", sim_drive_identity);
  add_drive_objects(objects(), params.drive, params.defaults,
                    supported_modes | mode_bit(params.drive.cia402.torque_mode), params.torque_rated_unit_Nm);
  for (SimPdoDefault& pdo : drive_pdos(params.defaults, params.drive.status_every_nth_sync,
                                       to_ms(params.rpdo_timeout_ns), to_ms(params.event_period_ns)))
    add_pdo(std::move(pdo));
}

cia402::OperationMode SimDrive::mode() const noexcept {
  return static_cast<cia402::OperationMode>(objects().value(mode_display_object));
}

double SimDrive::applied_torque_Nm() const noexcept {
  if (state_ != DriveState::operation_enabled) return 0;
  const double target_Nm =
      mode() == static_cast<cia402::OperationMode>(params_.drive.cia402.torque_mode)
          ? cia402::torque_from_per_mille(active_.target_torque_per_mille, params_.drive.torque_rated_Nm)
          : servo_torque_Nm();
  const double max_Nm = 1e-3 * max_per_mille() * params_.drive.torque_rated_Nm;
  return std::clamp(target_Nm, -max_Nm, max_Nm);
}

// Returns the servo torque at the motor: tau = d (v_target - v) in CSV, k (x_target - x) - d v in CSP.
double SimDrive::servo_torque_Nm() const noexcept {
  const DriveParams& drive = params_.drive;
  const double motor_rad_per_count = 1 / (drive.calibration.counts_per_unit * drive.joint_per_motor_rad);
  const auto target = [&](canopen::ObjectAddress object) {
    return static_cast<double>(objects().value(object));
  };
  double error_rad = 0, error_rad_per_s = -velocity_counts_per_s() * motor_rad_per_count;
  if (mode() == cia402::OperationMode::cyclic_synchronous_velocity)
    error_rad_per_s += target(target_velocity_object) * motor_rad_per_count;
  else if (mode() == cia402::OperationMode::cyclic_synchronous_position)
    error_rad =
        (target(target_position_object) - static_cast<double>(position_counts())) * motor_rad_per_count;
  else return 0;
  const double share = servo_stiffness_per_rad * error_rad + servo_damping_s_per_rad * error_rad_per_s;
  return drive.sign * drive.calibration.sign * drive.torque_max_Nm * share;
}

std::int64_t SimDrive::position_counts() const noexcept {
  const auto raw = static_cast<std::int32_t>(counts_at(q_, params_.drive.calibration));
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(raw + zero_counts_));
}

double SimDrive::velocity_counts_per_s() const noexcept {
  const Calibration& calibration = params_.drive.calibration;
  return calibration.sign * q_dot_ * calibration.counts_per_unit;
}

void SimDrive::trip(std::uint16_t error_code) noexcept {
  state_ = DriveState::fault;
  error_code_ = error_code;
  send_emergency();
}

void SimDrive::on_rpdo_received(int, Nanoseconds now) noexcept { t_received_ns_ = now; }

void SimDrive::on_rpdo(int, Nanoseconds now) noexcept {
  if (params_.quirks.controlword_period_ns > 0) return;
  if (++syncs_not_looked_ < params_.quirks.controlword_every_nth_sync) return;
  syncs_not_looked_ = 0;
  take_command();
  note_enabling(now);
}

void SimDrive::note_enabling(Nanoseconds now) noexcept {
  const bool fails = params_.quirks.error_when_enabled != 0 && state_ == DriveState::operation_enabled;
  if (!fails) t_error_ns_ = never;
  else if (t_error_ns_ == never) t_error_ns_ = now + params_.quirks.error_after_ns;
}

void SimDrive::take_command() noexcept {
  const std::uint16_t last_controlword = active_.controlword;
  active_ = {.controlword = static_cast<std::uint16_t>(objects().value(controlword_object)),
             .target_torque_per_mille = static_cast<std::int16_t>(objects().value(target_torque_object))};
  show(mode_display_object, objects().value(mode_object));
  const unsigned risen = active_.controlword & ~unsigned{last_controlword};
  if ((risen & cia402::fault_reset_bit) != 0) reset_fault();
  else obey(active_.controlword);
  if ((risen & cia402::control_start_homing) != 0) start_homing();
}

void SimDrive::start_homing() noexcept {
  if (mode() != cia402::OperationMode::homing || state_ != DriveState::operation_enabled) return;
  homing_ = cia402::HomingState::in_progress;
  begin_manoeuvre();
}

void SimDrive::begin_manoeuvre() noexcept {
  manoeuvre_begins_ = true;
  t_manoeuvre_ends_ns_ = never;
}

void SimDrive::finish_manoeuvre() noexcept {
  if (homing_ == cia402::HomingState::in_progress) finish_homing();
  constexpr auto stays = static_cast<std::int64_t>(cia402::QuickStopOption::slow_down_ramp_and_stay);
  if (state_ == DriveState::quick_stop_active && objects().value(quick_stop_option_object) < stays)
    state_ = DriveState::switch_on_disabled;
}

void SimDrive::finish_homing() noexcept {
  constexpr std::int64_t at_current_position_before = 35;  // method in older issues of CiA 402
  const std::int64_t method = objects().value(homing_method_object);
  const bool known = method == cia402::homing_at_current_position || method == at_current_position_before;
  homing_ = known ? cia402::HomingState::complete : cia402::HomingState::failed;
  if (known) zero_counts_ += objects().value(home_offset_object) - position_counts();
}

void SimDrive::on_reset() noexcept {
  zero_counts_ = 0;
  homing_ = cia402::HomingState::not_running;
  manoeuvre_begins_ = false;
  t_manoeuvre_ends_ns_ = never;
}

void SimDrive::quick_stop() noexcept {
  state_ = DriveState::quick_stop_active;
  begin_manoeuvre();
}

sdo::AbortCode SimDrive::may_write_object(canopen::ObjectAddress address, std::int64_t value) noexcept {
  if (address != mode_object || value == 0) return sdo::AbortCode::none;
  const auto supported = static_cast<std::uint32_t>(objects().value(supported_modes_object));
  return (supported & mode_bit(value)) != 0 ? sdo::AbortCode::none : sdo::AbortCode::invalid_value;
}

void SimDrive::on_object_written(canopen::ObjectAddress address, std::int64_t) noexcept {
  const bool looks_at_once = params_.quirks.controlword_period_ns == 0;
  if ((address == controlword_object || address == target_torque_object) && looks_at_once) take_command();
  if (address == mode_object) show(mode_display_object, objects().value(mode_object));
}

void SimDrive::on_heartbeat_lost(Nanoseconds) noexcept {
  if (!power_stage_works()) return;
  switch (static_cast<AbortConnection>(objects().value(abort_connection_option))) {
    case AbortConnection::no_action: break;
    case AbortConnection::fault: trip(emcy_heartbeat_lost); break;
    case AbortConnection::disable_voltage: state_ = DriveState::switch_on_disabled; break;
    case AbortConnection::quick_stop: quick_stop(); break;
  }
}

void SimDrive::on_nmt_state(Nanoseconds) noexcept {
  show(controlword_object, cia402::disable_voltage);
  show(target_torque_object, 0);
  active_ = {};
  if (nmt_state() == canopen::NmtState::boot_up) {
    state_ = DriveState::not_ready_to_switch_on;
    error_code_ = canopen::emcy_no_error;
  } else if (state_ != DriveState::fault) {
    state_ = DriveState::switch_on_disabled;
  }
}

void SimDrive::on_tick(Nanoseconds now) noexcept {
  if (const Nanoseconds period = params_.quirks.controlword_period_ns; period > 0 && now >= t_look_ns_) {
    t_look_ns_ = now + period;
    take_command();
    note_enabling(now);
  }
  if (now >= t_error_ns_) {
    t_error_ns_ = never;
    const bool to_fault = !params_.quirks.loses_power_only;
    state_ = to_fault ? DriveState::fault : DriveState::switch_on_disabled;
    if (to_fault) error_code_ = params_.quirks.error_when_enabled;
  }
  if (manoeuvre_begins_) t_manoeuvre_ends_ns_ = now + manoeuvre_duration_ns;
  manoeuvre_begins_ = false;
  if (now >= t_manoeuvre_ends_ns_) {
    t_manoeuvre_ends_ns_ = never;
    finish_manoeuvre();
  }
  if (power_stage_works() && now >= command_deadline()) trip(canopen::emcy_rpdo_timeout);
}

Nanoseconds SimDrive::device_timer() const noexcept {
  const Nanoseconds t_look_ns = params_.quirks.controlword_period_ns > 0 ? t_look_ns_ : never;
  return std::min(
      {t_manoeuvre_ends_ns_, power_stage_works() ? command_deadline() : never, t_look_ns, t_error_ns_});
}

// Returns the deadline of RPDO1; `never` outside operational, where no PDOs are exchanged and SDO commands
// the drive.
Nanoseconds SimDrive::command_deadline() const noexcept {
  if (!is_operational()) return never;
  const SimPdo* command = find_pdo(PdoDirection::receive, 1);
  return command->timer_ns() > 0 ? t_received_ns_ + command->timer_ns() : never;
}

void SimDrive::sample() noexcept {
  const double torque_per_mille = 1000 * applied_torque_Nm() / params_.drive.torque_rated_Nm;
  show(statusword_object, statusword());
  show(error_code_object, error_code_);
  show(position_object, position_counts());
  show(velocity_object, saturate_to<std::int32_t>(velocity_counts_per_s()));
  show(torque_object, saturate_to<std::int16_t>(torque_per_mille));
}

void SimDrive::show(canopen::ObjectAddress address, std::int64_t value) noexcept {
  objects().find(address)->value = value;
}

// State transitions of CiA 402; commands by their masks over bits 7, 3, 2, 1, 0.
void SimDrive::obey(std::uint16_t controlword) noexcept {
  const bool disable_voltage = (controlword & 0x82u) == 0x00;
  const bool quick_stop_bits = (controlword & 0x86u) == 0x02;
  const bool shutdown = (controlword & 0x87u) == 0x06;
  const bool switch_on = (controlword & 0x87u) == 0x07;  // bit 3 belongs to the next transition
  const bool disable_operation = (controlword & 0x8Fu) == 0x07;
  const bool enable_operation = (controlword & 0x8Fu) == 0x0F;

  switch (state_) {
    case DriveState::switch_on_disabled:
      if (shutdown) state_ = DriveState::ready_to_switch_on;
      break;
    case DriveState::ready_to_switch_on:
      if (switch_on) state_ = DriveState::switched_on;
      else if (disable_voltage || quick_stop_bits) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::switched_on:
      if (enable_operation) state_ = DriveState::operation_enabled;
      else if (shutdown) state_ = DriveState::ready_to_switch_on;
      else if (disable_voltage || quick_stop_bits) state_ = DriveState::switch_on_disabled;
      break;
    case DriveState::operation_enabled:
      if (disable_operation) state_ = DriveState::switched_on;
      else if (shutdown) state_ = DriveState::ready_to_switch_on;
      else if (quick_stop_bits) quick_stop();
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
  // Error register 1001h: generic error; also communication error for codes 8xxxh.
  const bool communication = (error_code_ >> 12) == 0x8;
  const std::uint8_t error_register = error_code_ == 0 ? 0x00 : communication ? 0x11 : 0x01;
  show({0x1001, 0}, error_register);
  send(canopen::make_emergency(
      {.node = node_id(), .error_code = error_code_, .error_register = error_register}));
}

std::uint16_t SimDrive::statusword() const noexcept {
  const double target_per_mille = active_.target_torque_per_mille;
  const bool enabled = state_ == DriveState::operation_enabled;
  const bool limited = enabled && std::abs(target_per_mille) > max_per_mille();
  unsigned word = cia402::encode_state(state_) | cia402::status_voltage_enabled | cia402::status_remote;
  if (limited) word |= params_.drive.cia402.limit_mask;
  if (mode() == cia402::OperationMode::homing) word |= cia402::encode_homing(homing_);
  else if (enabled && !(limited && params_.quirks.limit_clears_follow_bit))
    word |= params_.drive.cia402.follows_mask;
  word = (word & ~unsigned{params_.quirks.status_clear}) | params_.quirks.status_set;
  return static_cast<std::uint16_t>(word);
}

bool SimDrive::power_stage_works() const noexcept {
  return state_ == DriveState::operation_enabled || state_ == DriveState::quick_stop_active;
}

double SimDrive::max_per_mille() const noexcept {
  if (params_.quirks.max_torque_per_mille > 0) return params_.quirks.max_torque_per_mille;
  return 1000 * params_.drive.torque_max_Nm / params_.drive.torque_rated_Nm;
}

}  // namespace godobject
