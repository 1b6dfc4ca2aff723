#include "hal/drive/cia402_link.h"

#include <algorithm>
#include <cstdlib>

#include "hal/base/format.h"
#include "hal/drive/cia402_text.h"

namespace godobject {

using cia402::DriveState;

DriveMessage Cia402Link::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {
  if (frame.id == canopen::tpdo_cob_id(2, params_.node_id)) {
    cia402::Event event;
    const ParseResult result = cia402::parse_event(frame, params_.node_id, event);
    if (result != ParseResult::ok) return {.result = result};
    shown_mode_ = event.mode;
    out.velocity_counts_per_s = event.velocity_counts_per_s;
    out.error_code = event.error_code;
    out.own_state = cia402::own_state(statusword_, shown_mode_);
    return {.result = result};
  }
  cia402::Status status;
  const ParseResult result = cia402::parse_status(frame, params_.node_id, status);
  if (result != ParseResult::ok) return {.result = result};
  statusword_ = status.statusword;
  state_ = cia402::decode_state(statusword_);
  const Cia402Params& bits = params_.cia402;
  const bool limits = (statusword_ & bits.limit_mask) != 0 || is_held_back(status.actual_torque_per_mille);
  const bool bit_set = bits.follows_mask == 0 || (statusword_ & bits.follows_mask) != 0;
  follows_ = state_ == DriveState::operation_enabled && (bit_set || (follows_ && limits));
  out.position_counts = static_cast<std::uint32_t>(status.position_counts);
  out.torque_Nm = cia402::torque_from_per_mille(status.actual_torque_per_mille, params_.torque_rated_Nm);
  out.state = motor_state();
  out.internal_limit = (statusword_ & bits.limit_mask) != 0 || (follows_ && !bit_set);
  out.own_state = cia402::own_state(statusword_, shown_mode_);
  out.has_own_state = true;
  out.powered = state_ == DriveState::operation_enabled;
  return {.result = result, .position = true};
}

/// True if the actual torque is in the direction of a target and smaller. Some drives limit without setting a
/// bit.
bool Cia402Link::is_held_back(std::int16_t actual_per_mille) const noexcept {
  return std::ranges::any_of(targets_per_mille_, [actual_per_mille](int target) {
    return target * actual_per_mille > 0 && std::abs(actual_per_mille) < std::abs(target);
  });
}

MotorState Cia402Link::motor_state() const noexcept {
  const bool other_mode = shown_mode_ && *shown_mode_ != params_.cia402.torque_mode;
  switch (state_) {
    case DriveState::operation_enabled:
      return follows_ && !other_mode ? MotorState::enabled : MotorState::off;
    case DriveState::fault_reaction_active:
    case DriveState::fault: return MotorState::fault;
    case DriveState::unknown: return MotorState::unknown;
    default: return MotorState::off;
  }
}

std::uint16_t Cia402Link::controlword(DriveGoal goal, Nanoseconds now) const noexcept {
  const bool held = t_reset_edge_ns_ && now - *t_reset_edge_ns_ < cia402::fault_reset_hold_ns;
  switch (goal) {
    case DriveGoal::hold:
      return state_ == DriveState::operation_enabled ? cia402::enable_operation : cia402::disable_voltage;
    case DriveGoal::enable:
      if (state_ == DriveState::fault && held) return controlword_ & cia402::fault_reset_bit;
      return cia402::next_controlword(state_, controlword_, true);
    case DriveGoal::quick_stop: return cia402::quick_stop;
    case DriveGoal::off: break;
  }
  return cia402::disable_voltage;
}

DriveFrame Cia402Link::command(const DriveOrder& order, Nanoseconds now) const noexcept {
  const std::uint16_t word = controlword(order.goal, now);
  const std::int16_t per_mille =
      cia402::torque_to_per_mille(order.torque_Nm, params_.torque_rated_Nm, params_.torque_max_Nm);
  return {.frame = cia402::make_command(params_.node_id, {word, per_mille}), .step = word};
}

void Cia402Link::sent(const DriveFrame& command, Nanoseconds now) noexcept {
  if (((controlword_ ^ command.step) & cia402::fault_reset_bit) != 0) t_reset_edge_ns_ = now;
  controlword_ = command.step;
  cia402::Command sent;
  if (!command.frame || cia402::parse_command(*command.frame, params_.node_id, sent) != ParseResult::ok)
    return;
  targets_per_mille_ = {targets_per_mille_[1], sent.target_torque_per_mille};
}

std::vector<CyclicMessage> Cia402Link::messages(double cycle_s, double event_period_s) const {
  const std::uint8_t node = params_.node_id;
  return {{"torque command", cia402::make_command(node, {}), cycle_s},
          {"drive status", cia402::make_status(node, {}), cycle_s * params_.status_every_nth_sync},
          {"drive event", cia402::make_event(node, {}), event_period_s}};
}

namespace cia402 {

std::string state_text(const DriveParams& params, std::uint32_t own_state) {
  const auto statusword = static_cast<std::uint16_t>(own_state);
  const DriveState state = decode_state(statusword);
  std::string text = format("%s (6041h = %04Xh)", name_of(state), unsigned{statusword});
  if (state != DriveState::operation_enabled) return text;
  const bool mode_known = own_state >> 24 != 0;
  const auto mode = static_cast<std::int8_t>(own_state >> 16 & 0xFF);
  if (mode_known && mode != params.cia402.torque_mode)
    text += format(", its mode 6061h is %d, not %d", int{mode}, int{params.cia402.torque_mode});
  if (params.cia402.follows_mask != 0 && (statusword & params.cia402.follows_mask) == 0)
    text += format(", bit %d is not set: it does not follow its command",
                   std::countr_zero(params.cia402.follows_mask));
  return text;
}

std::string error_text(std::uint32_t error_code, std::uint32_t) { return error_code_text(error_code); }

}  // namespace cia402
}  // namespace godobject
