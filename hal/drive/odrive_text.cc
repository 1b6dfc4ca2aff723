// Texts of CAN Simple messages.
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

struct ErrorBit {
  std::uint32_t bit;
  const char* text;
};

constexpr std::array error_bits{
    ErrorBit{0x0000'0001, "initialising"},
    ErrorBit{0x0000'0002, "system level"},
    ErrorBit{0x0000'0004, "timing"},
    ErrorBit{0x0000'0008, "missing estimate"},
    ErrorBit{0x0000'0010, "bad configuration"},
    ErrorBit{0x0000'0020, "gate driver"},
    ErrorBit{0x0000'0040, "missing input"},
    ErrorBit{0x0000'0100, "DC bus over-voltage"},
    ErrorBit{0x0000'0200, "DC bus under-voltage"},
    ErrorBit{0x0000'0400, "DC bus over-current"},
    ErrorBit{0x0000'0800, "DC bus over-current of regeneration"},
    ErrorBit{0x0000'1000, "current limit"},
    ErrorBit{0x0000'2000, "motor too hot"},
    ErrorBit{0x0000'4000, "inverter too hot"},
    ErrorBit{0x0000'8000, "velocity limit"},
    ErrorBit{0x0001'0000, "position limit"},
    ErrorBit{error_watchdog, "watchdog"},
    ErrorBit{error_estop, "emergency stop"},
    ErrorBit{0x0400'0000, "spin-out"},
    ErrorBit{0x0800'0000, "brake resistor disarmed"},
    ErrorBit{0x1000'0000, "thermistor disconnected"},
    ErrorBit{0x4000'0000, "calibration"},
};

// Axis errors of firmware 0.5.
constexpr std::array error_bits_0_5{
    ErrorBit{0x0000'0001, "invalid state: is the axis calibrated?"},
    ErrorBit{0x0000'0040, "motor failed"},
    ErrorBit{0x0000'0080, "sensorless estimator failed"},
    ErrorBit{0x0000'0100, "encoder failed"},
    ErrorBit{0x0000'0200, "controller failed"},
    ErrorBit{0x0000'0800, "watchdog"},
    ErrorBit{0x0000'1000, "end stop at the minimum"},
    ErrorBit{0x0000'2000, "end stop at the maximum"},
    ErrorBit{0x0000'4000, "emergency stop"},
    ErrorBit{0x0002'0000, "homing without an end stop"},
    ErrorBit{0x0004'0000, "too hot"},
    ErrorBit{0x0008'0000, "unknown position"},
};

// Firmware 0.6: outcome of the last procedure, including entering closed loop.
constexpr std::array procedure_results{
    "success",           "busy",
    "cancelled",         "disarmed",
    "no response",       "pole pairs or counts per turn do not match",
    "phase resistance",  "phase inductance",
    "unbalanced phases", "invalid motor type",
    "Hall state",        "time-out",
    "no end stop",       "invalid state",
    "not calibrated",    "not converging",
};

Heartbeat heartbeat_of(std::uint32_t error, std::uint32_t own_state) {
  const auto byte = [own_state](int n) { return static_cast<std::uint8_t>(own_state >> 8 * n); };
  return {.error = error, .axis_state = byte(0), .flags = {byte(1), byte(2), byte(3)}};
}

/// Returns the names of the set bits.
std::string names_of_error(const Heartbeat& heartbeat) {
  const std::span<const ErrorBit> bits = is_firmware_0_5(heartbeat)
                                             ? std::span<const ErrorBit>(error_bits_0_5)
                                             : std::span<const ErrorBit>(error_bits);
  std::string text;
  for (const auto& [bit, name] : bits)
    if ((heartbeat.error & bit) != 0) text += std::string(text.empty() ? " " : ", ") + name;
  return text;
}

std::string text_of_error(const Heartbeat& heartbeat) {
  std::string text;
  if (heartbeat.error != 0)
    text = format(", error %08Xh", static_cast<unsigned>(heartbeat.error)) + names_of_error(heartbeat);
  if (!has_flagged_error(heartbeat)) return text;
  constexpr std::array devices{"motor", "encoder", "controller"};
  for (std::size_t i = 0; i < devices.size(); ++i)
    if ((heartbeat.flags[i] & 1u) != 0) text += std::string(", error of the ") + devices[i];
  return text;
}

/// Returns the outcome of the last procedure unless it is success; empty for firmware 0.5, which sends flags
/// there.
std::string text_of_procedure(const Heartbeat& heartbeat) {
  const std::uint8_t result = heartbeat.flags[0];
  if (is_firmware_0_5(heartbeat) || heartbeat.axis_state != axis_idle || result == 0) return "";
  return format(", procedure result %d", int{result}) +
         (result < procedure_results.size() ? std::string(" ") + procedure_results[result] : "");
}

/// Returns the first 32-bit number of a message.
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
      return text_of_axis_state(heartbeat.axis_state) + text_of_error(heartbeat);
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

std::string state_text(const DriveParams&, std::uint32_t own_state) {
  const Heartbeat heartbeat = heartbeat_of(0, own_state);
  return text_of_axis_state(heartbeat.axis_state) + text_of_error(heartbeat) + text_of_procedure(heartbeat);
}

std::string error_text(std::uint32_t error_code, std::uint32_t own_state) {
  const Heartbeat heartbeat = heartbeat_of(error_code, own_state);
  return format("error %08Xh", static_cast<unsigned>(error_code)) + names_of_error(heartbeat);
}

DriveText describe(const CanFrame& frame) {
  CanFrame answer = frame;  // the requested answer
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
