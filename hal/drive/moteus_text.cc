// Texts of moteus frames.
#include "hal/base/format.h"
#include "hal/drive/moteus.h"

namespace godobject::moteus {
namespace {

std::string text_of_mode(int mode) {
  switch (mode) {
    case mode_stopped: return "stopped";
    case mode_fault: return "fault";
    case mode_position: return "position mode";
    case mode_timeout: return "timed out";
    default: return "mode " + std::to_string(mode);
  }
}

DriveText describe_reply(const CanFrame& frame, std::uint8_t node) {
  DriveText text{.node = node, .name = "reply"};
  Reply reply;
  if (parse_reply(frame, node, reply) != ParseResult::ok) return text;
  text.position_counts = saturate_to<std::int32_t>(counts_per_motor_turn * reply.position_rev);
  text.value = format("%s, torque %+.4f Nm", text_of_mode(reply.mode).c_str(), reply.torque_Nm);
  if (reply.fault != 0) text.value += ", fault " + std::to_string(reply.fault);
  return text;
}

void append(std::string& text, const std::string& more) { text += text.empty() ? more : ", " + more; }

DriveText describe_request(const CanFrame& frame, std::uint8_t node) {
  bool reads = false, writes = false;
  std::string value;
  SubframeReader reader(frame.bytes());
  for (Subframe subframe; reader.next(subframe);) {
    reads = reads || subframe.kind == SubframeKind::read;
    if (subframe.kind != SubframeKind::write) continue;
    writes = true;
    for (std::uint32_t i = 0; i < subframe.count; ++i) {
      const std::uint32_t reg = subframe.first + i;
      if (reg == mode) append(value, text_of_mode(saturate_to<int>(subframe.value(i))));
      if (reg == feedforward_torque) append(value, format("torque %+.4f Nm", subframe.value(i)));
    }
  }
  const char* const name = writes && reads ? "command and query" : writes ? "command" : "query";
  return {.node = node, .name = name, .value = value};
}

// Returns the text of a fault: register 00Fh while the mode is 1 (fault).
const char* name_of_fault(std::uint32_t fault) {
  switch (fault) {
    case 32: return "calibration";
    case 33: return "motor driver";
    case 34: return "over-voltage";
    case 35: return "encoder";
    case 36: return "motor not configured: calibrate it with moteus_tool";
    case 37: return "PWM cycle overrun";
    case 38: return "too hot";
    case 39: return "outside its limits: see servopos.position_min and position_max";
    case 40: return "under-voltage";
    case 41: return "configuration changed";
    case 42: return "no valid angle for commutation";
    case 43: return "no valid position";
    case 44: return "driver could not be enabled";
    case 46: return "timing violation";
    default: return "see its manual";
  }
}

}  // namespace

std::string state_text(const DriveParams&, std::uint32_t own_state) {
  const int mode = static_cast<int>(own_state);
  const std::string name = text_of_mode(mode), number = "mode " + std::to_string(mode);
  return name == number ? name : name + " (" + number + ")";
}

std::string error_text(std::uint32_t error_code, std::uint32_t) {
  return "fault " + std::to_string(error_code) + ", " + name_of_fault(error_code);
}

DriveText describe(const CanFrame& frame) {
  if (const std::uint8_t node = sender(frame); node != 0) return describe_reply(frame, node);
  const auto node = static_cast<std::uint8_t>(frame.id & 0x7F);
  const bool from_host = frame.fd && (frame.id == request_id(node) || frame.id == command_id(node));
  return from_host && node != 0 ? describe_request(frame, node) : DriveText{};
}

}  // namespace godobject::moteus
