#include "hal/drive/cia402_link.h"

namespace godobject {

using cia402::DriveState;

DriveMessage Cia402Link::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {
  if (frame.id == canopen::tpdo_cob_id(2, params_.node_id)) {
    cia402::Event event;
    const ParseResult result = cia402::parse_event(frame, params_.node_id, event);
    if (result != ParseResult::ok) return {.result = result};
    other_mode_ = event.mode != cia402::mode_cyclic_synchronous_torque;
    out.velocity_counts_per_s = event.velocity_counts_per_s;
    out.error_code = event.error_code;
    return {.result = result};
  }
  cia402::Status status;
  const ParseResult result = cia402::parse_status(frame, params_.node_id, status);
  if (result != ParseResult::ok) return {.result = result};
  state_ = cia402::decode_state(status.statusword);
  out.position_counts = static_cast<std::uint32_t>(status.position_counts);
  out.torque_Nm = cia402::torque_from_per_mille(status.actual_torque_per_mille, params_.torque_rated_Nm);
  out.state = motor_state(status.statusword);
  out.internal_limit = (status.statusword & cia402::status_internal_limit) != 0;
  return {.result = result, .position = true};
}

MotorState Cia402Link::motor_state(std::uint16_t statusword) const noexcept {
  switch (state_) {
    case DriveState::operation_enabled:
      return (statusword & cia402::status_follows_command) != 0 && !other_mode_ ? MotorState::enabled
                                                                                : MotorState::off;
    case DriveState::fault_reaction_active:
    case DriveState::fault: return MotorState::fault;
    case DriveState::unknown: return MotorState::unknown;
    default: return MotorState::off;
  }
}

std::uint16_t Cia402Link::controlword(DriveGoal goal) const noexcept {
  switch (goal) {
    case DriveGoal::hold:
      return state_ == DriveState::operation_enabled ? cia402::enable_operation : cia402::disable_voltage;
    case DriveGoal::enable: return cia402::next_controlword(state_, controlword_, true);
    case DriveGoal::quick_stop: return cia402::quick_stop;
    case DriveGoal::off: break;
  }
  return cia402::disable_voltage;
}

DriveFrame Cia402Link::command(const DriveOrder& order, Nanoseconds) const noexcept {
  const std::uint16_t word = controlword(order.goal);
  const std::int16_t per_mille =
      cia402::torque_to_per_mille(order.torque_Nm, params_.torque_rated_Nm, params_.torque_max_Nm);
  return {.frame = cia402::make_command(params_.node_id, {word, per_mille}), .step = word};
}

std::vector<CyclicMessage> Cia402Link::messages(double cycle_s, double event_period_s) const {
  const std::uint8_t node = params_.node_id;
  return {{"torque command", cia402::make_command(node, {}), cycle_s},
          {"drive status", cia402::make_status(node, {}), cycle_s * params_.status_every_nth_sync},
          {"drive event", cia402::make_event(node, {}), event_period_s}};
}

}  // namespace godobject
