#include "hal/drive/odrive.h"

namespace godobject {

namespace odrive {

ParseResult parse_reals(const CanFrame& frame, std::uint8_t node, Command command, float& first,
                        float& second) noexcept {
  const ParseResult result = check(frame, node, command, 8);
  if (result != ParseResult::ok) return result;
  float a = 0, b = 0;
  ByteReader(frame.bytes()).get(a).get(b);
  if (!std::isfinite(a) || !std::isfinite(b)) return ParseResult::bad_value;
  first = a;
  second = b;
  return result;
}

}  // namespace odrive

namespace {

// Retry interval of a step: its result appears in a heartbeat, so two heartbeats at the default period plus
// margin.
constexpr Nanoseconds retry_ns = 250'000'000;

}  // namespace

DriveMessage OdriveLink::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {
  odrive::EncoderEstimates estimates;
  ParseResult result = odrive::parse_encoder_estimates(frame, node_, estimates);
  if (result != ParseResult::other_message) {
    const double counts = counts_per_motor_turn * static_cast<double>(estimates.position_rev);
    if (std::abs(counts) > std::numeric_limits<std::int32_t>::max()) result = ParseResult::bad_value;
    if (result != ParseResult::ok) return {.result = result};
    out.position_counts = static_cast<std::uint32_t>(saturate_to<std::int32_t>(counts));
    out.velocity_counts_per_s = counts_per_motor_turn * static_cast<double>(estimates.velocity_rev_per_s);
    return {.result = result, .position = true};
  }
  odrive::Torques torques;
  result = odrive::parse_torques(frame, node_, torques);
  if (result == ParseResult::ok) out.torque_Nm = static_cast<double>(torques.estimate_Nm);
  if (result != ParseResult::other_message) return {.result = result};
  result = odrive::parse_heartbeat(frame, node_, heartbeat_);
  if (result != ParseResult::ok) return {.result = result};
  heard_ = true;
  out.error_code = heartbeat_.error;
  out.own_state = odrive::own_state(heartbeat_);
  out.has_own_state = true;
  out.powered = heartbeat_.axis_state == odrive::axis_closed_loop;
  out.state = enabled() ? MotorState::enabled : has_error() ? MotorState::fault : MotorState::off;
  return {.result = result, .alive = true};
}

bool OdriveLink::enabled() const noexcept {
  return heard_ && heartbeat_.axis_state == odrive::axis_closed_loop && !has_error() && torque_mode_sent_;
}

// Returns the next step towards enabled. Errors are cleared first. The mode is sent before each state change,
// because the drive may have rebooted.
OdriveLink::Step OdriveLink::next_step(Nanoseconds now) const noexcept {
  const Step next = has_error() ? clear_errors : torque_mode;
  if (next == torque_mode && last_step_ == torque_mode) return closed_loop;
  const bool pending = last_step_ == next || (next == torque_mode && last_step_ == closed_loop);
  return pending && now - t_last_step_ns_ < retry_ns ? waiting : next;
}

DriveFrame OdriveLink::command(const DriveOrder& order, Nanoseconds now) const noexcept {
  const DriveFrame idle{odrive::make_set_axis_state(node_, odrive::axis_idle), nothing};
  const CanFrame torque = odrive::make_input_torque(node_, static_cast<float>(order.torque_Nm));
  if (order.goal == DriveGoal::off) return idle;
  if (!heard_) return {};
  if (order.goal == DriveGoal::quick_stop)
    return heartbeat_.axis_state == odrive::axis_idle ? DriveFrame{} : idle;
  if (order.goal == DriveGoal::hold || enabled()) return {torque, nothing};
  switch (const Step step = next_step(now)) {
    case clear_errors: return {odrive::make_clear_errors(node_), step};
    case torque_mode: return {odrive::make_torque_mode(node_), step};
    case closed_loop: return {odrive::make_set_axis_state(node_, odrive::axis_closed_loop), step};
    case waiting:
    case nothing: break;
  }
  return {torque, waiting};
}

void OdriveLink::sent(const DriveFrame& command, Nanoseconds now) noexcept {
  if (command.step == waiting) return;
  last_step_ = static_cast<Step>(command.step);
  t_last_step_ns_ = now;
  if (last_step_ == torque_mode) torque_mode_sent_ = true;
}

std::vector<CyclicMessage> OdriveLink::messages(double cycle_s, double) const {
  return {{"encoder request", odrive::make_request(node_, odrive::Command::encoder_estimates), cycle_s},
          {"encoder estimates", odrive::make_encoder_estimates(node_, {}), cycle_s},
          {"torque command", odrive::make_input_torque(node_, 0), cycle_s},
          {"torques", odrive::make_torques(node_, {}), odrive::torques_period_s},
          {"drive heartbeat", odrive::make_heartbeat(node_, {}), odrive::heartbeat_period_s}};
}

}  // namespace godobject
