// CiA 402 beyond cyclic torque: modes of operation, velocity and position commands, quick stop options.
#pragma once

#include "hal/drive/cia402.h"

namespace godobject::cia402 {

/// 6060h (requested) and 6061h (in effect), i8.
enum class OperationMode : std::int8_t {
  none = 0,
  profile_position = 1,
  velocity = 2,
  profile_velocity = 3,
  profile_torque = 4,
  homing = 6,
  interpolated_position = 7,
  cyclic_synchronous_position = 8,
  cyclic_synchronous_velocity = 9,
  cyclic_synchronous_torque = 10,
};

/// True if 6502h lists the mode: mode n is bit n - 1 (CST 200h, CSV 100h, CSP 80h, homing 20h).
constexpr bool supports(std::uint32_t supported_modes_6502h, OperationMode mode) noexcept {
  const int bit = static_cast<int>(mode) - 1;
  return bit >= 0 && bit < 32 && ((supported_modes_6502h >> bit) & 1u) != 0;
}

/// 605Ah, i16: behaviour of a drive between a quick stop and standstill.
enum class QuickStopOption : std::int16_t {
  disable = 0,                  // power stage off, coasts
  slow_down_ramp = 1,           // 6084h, then Switch On Disabled
  quick_stop_ramp = 2,          // 6085h, then Switch On Disabled
  current_limit = 3,            // then Switch On Disabled
  slow_down_ramp_and_stay = 5,  // stays in Quick Stop Active
  quick_stop_ramp_and_stay = 6,
  current_limit_and_stay = 7,
};

/// Quantity set by a cyclic command; each kind requires its mode in effect.
enum class CommandKind : std::uint8_t {
  torque,    // CST, 6071h in per mille of 6076h: RPDO1 (make_command)
  velocity,  // CSV, 60FFh in counts/s: RPDO3
  position,  // CSP, 607Ah in counts: RPDO2
};

constexpr OperationMode mode_of(CommandKind kind) noexcept {
  switch (kind) {
    case CommandKind::velocity: return OperationMode::cyclic_synchronous_velocity;
    case CommandKind::position: return OperationMode::cyclic_synchronous_position;
    case CommandKind::torque: break;
  }
  return OperationMode::cyclic_synchronous_torque;
}

/// Host to drive in CSP and CSV: {6040h:16, 607Ah:32} or {6040h:16, 60FFh:32}.
struct MotionCommand {
  CommandKind kind = CommandKind::velocity;  // not torque
  std::uint16_t controlword = disable_voltage;
  std::int32_t target = 0;  // counts, counts/s
};
inline constexpr std::uint8_t motion_command_size = 6;

constexpr std::uint32_t motion_command_cob_id(CommandKind kind, std::uint8_t node) noexcept {
  return canopen::rpdo_cob_id(kind == CommandKind::position ? 2 : 3, node);
}

constexpr CanFrame make_motion_command(std::uint8_t node, const MotionCommand& command) noexcept {
  CanFrame frame{.id = motion_command_cob_id(command.kind, node), .size = motion_command_size};
  ByteWriter(frame.data).put(command.controlword).put(command.target);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_motion_command(const CanFrame& frame, std::uint8_t node,
                                                         MotionCommand& out) noexcept {
  for (const CommandKind kind : {CommandKind::position, CommandKind::velocity}) {
    const ParseResult result =
        canopen::check_message(frame, motion_command_cob_id(kind, node), motion_command_size);
    if (result == ParseResult::other_message) continue;
    if (result != ParseResult::ok) return result;
    out.kind = kind;
    ByteReader(frame.bytes()).get(out.controlword).get(out.target);
    return ParseResult::ok;
  }
  return ParseResult::other_message;
}

}  // namespace godobject::cia402
