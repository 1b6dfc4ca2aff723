// CAN Simple in words.
#include "hal/base/format.h"
#include "hal/drive/odrive.h"

namespace godobject::odrive {
namespace {

std::string name_of(Command command) {
  switch (command) {
    case Command::heartbeat: return "heartbeat";
    case Command::estop: return "emergency stop";
    case Command::set_axis_state: return "axis state";
    case Command::encoder_estimates: return "estimates";
    case Command::set_controller_mode: return "controller mode";
    case Command::set_input_torque: return "torque command";
    case Command::torques: return "torques";
    case Command::clear_errors: return "clear errors";
  }
  return format("message %02Xh", static_cast<unsigned>(command));
}

std::string text_of_axis_state(std::uint32_t state) {
  if (state == axis_idle) return "idle";
  if (state == axis_closed_loop) return "closed loop";
  return "axis state " + std::to_string(state);
}

std::string text_of_error(std::uint32_t error) {
  if (error == 0) return "";
  return format(", error %08Xh%s%s", static_cast<unsigned>(error),
                (error & error_watchdog) != 0 ? " watchdog" : "",
                (error & error_estop) != 0 ? " emergency stop" : "");
}

/// The number of a message that has one of 32 bits.
template <class Number>
std::optional<Number> number_of(const CanFrame& frame) {
  Number number{};
  if (frame.size < sizeof number) return std::nullopt;
  ByteReader(frame.bytes()).get(number);
  return number;
}

std::string value_of(const CanFrame& frame, std::uint8_t node, Command command) {
  Heartbeat heartbeat;
  Torques torques;
  switch (command) {
    case Command::heartbeat:
      if (parse_heartbeat(frame, node, heartbeat) != ParseResult::ok) return "";
      return text_of_axis_state(heartbeat.axis_state) + text_of_error(heartbeat.error);
    case Command::torques:
      if (parse_torques(frame, node, torques) != ParseResult::ok) return "";
      return format("torque %+.4f Nm, target %+.4f Nm", static_cast<double>(torques.estimate_Nm),
                    static_cast<double>(torques.target_Nm));
    case Command::set_axis_state:
      if (const auto state = number_of<std::uint32_t>(frame)) return text_of_axis_state(*state);
      return "";
    case Command::set_input_torque:
      if (const auto torque_Nm = number_of<float>(frame))
        return format("torque %+.4f Nm", static_cast<double>(*torque_Nm));
      return "";
    case Command::set_controller_mode:
      if (const auto mode = number_of<std::uint32_t>(frame))
        return *mode == control_torque ? "torque control" : "control mode " + std::to_string(*mode);
      return "";
    case Command::encoder_estimates:
    case Command::estop:
    case Command::clear_errors: break;
  }
  return "";
}

}  // namespace

DriveText describe(const CanFrame& frame) {
  CanFrame answer = frame;  // that a request asks for
  answer.remote = false;
  const std::uint8_t node = sender(answer);
  if (node == 0) return {};
  const auto command = static_cast<Command>(frame.id & 0x1F);
  if (frame.remote) return {.node = node, .name = name_of(command) + " request"};
  DriveText text{.node = node, .name = name_of(command), .value = value_of(frame, node, command)};
  EncoderEstimates estimates;
  if (parse_encoder_estimates(frame, node, estimates) == ParseResult::ok) {
    text.position_counts =
        saturate_to<std::int32_t>(counts_per_motor_turn * static_cast<double>(estimates.position_rev));
    text.value = format("velocity %+.4f rev/s", static_cast<double>(estimates.velocity_rev_per_s));
  }
  return text;
}

}  // namespace godobject::odrive
