// Motor drives (CiA 402) in cyclic synchronous torque mode: state machine and messages.
// PDO layout: RPDO1 {6040h:16, 6071h:16}, TPDO1 {6041h:16, 6064h:32, 6077h:16},
// TPDO2 {606Ch:32, 6061h:8, 603Fh:16}.
#pragma once

#include <algorithm>

#include "hal/canopen/canopen.h"

namespace godobject::cia402 {

enum class DriveState : std::uint8_t {
  not_ready_to_switch_on,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop_active,
  fault_reaction_active,
  fault,
  unknown,  // the statusword matches no state of the standard
};

// Commands in the controlword 6040h.
inline constexpr std::uint16_t disable_voltage = 0x0000;
inline constexpr std::uint16_t quick_stop = 0x0002;
inline constexpr std::uint16_t shutdown = 0x0006;
inline constexpr std::uint16_t switch_on = 0x0007;  // in Operation Enabled: disables operation
inline constexpr std::uint16_t enable_operation = 0x000F;
inline constexpr std::uint16_t fault_reset_bit = 0x0080;  // acts on its rising edge

// Bits of the statusword 6041h that do not encode the state.
inline constexpr std::uint16_t status_voltage_enabled = 1u << 4;
inline constexpr std::uint16_t status_warning = 1u << 7;
inline constexpr std::uint16_t status_remote = 1u << 9;
inline constexpr std::uint16_t status_internal_limit = 1u << 11;
inline constexpr std::uint16_t status_follows_command = 1u << 12;  // in the cyclic synchronous modes

// 6060h, 6061h; other modes: cia402_modes.h
inline constexpr std::int8_t mode_cyclic_synchronous_torque = 10;

constexpr DriveState decode_state(std::uint16_t statusword) noexcept {
  switch (statusword & 0x4Fu) {
    case 0x00: return DriveState::not_ready_to_switch_on;
    case 0x40: return DriveState::switch_on_disabled;
    case 0x0F: return DriveState::fault_reaction_active;
    case 0x08: return DriveState::fault;
    default: break;
  }
  switch (statusword & 0x6Fu) {
    case 0x21: return DriveState::ready_to_switch_on;
    case 0x23: return DriveState::switched_on;
    case 0x27: return DriveState::operation_enabled;
    case 0x07: return DriveState::quick_stop_active;
    default: return DriveState::unknown;
  }
}

/// Returns the statusword bits of a state, the inverse of decode_state. `unknown` gives those of
/// not_ready_to_switch_on.
constexpr std::uint16_t encode_state(DriveState state) noexcept {
  switch (state) {
    case DriveState::switch_on_disabled: return 0x40;
    case DriveState::ready_to_switch_on: return 0x21;
    case DriveState::switched_on: return 0x23;
    case DriveState::operation_enabled: return 0x27;
    case DriveState::quick_stop_active: return 0x07;
    case DriveState::fault_reaction_active: return 0x0F;
    case DriveState::fault: return 0x08;
    case DriveState::not_ready_to_switch_on:
    case DriveState::unknown: break;
  }
  return 0x00;
}

/// Hold time of each level of the fault reset bit, ns, unless the state changes earlier. A drive acts on the
/// edge of bit 7 when it reads the controlword: some every 2nd SYNC or 8 ms, busy ones later.
inline constexpr Nanoseconds fault_reset_hold_ns = 50'000'000;

/// Toggles the fault reset bit (7) in state Fault. Call it when fault_reset_hold_ns is over.
constexpr std::uint16_t fault_reset_controlword(std::uint16_t last_controlword) noexcept {
  return (last_controlword & fault_reset_bit) == 0 ? fault_reset_bit : disable_voltage;
}

/// Returns the controlword that leads one state closer to Operation Enabled; out of Fault only if
/// `reset_fault`.
constexpr std::uint16_t next_controlword(DriveState state, std::uint16_t last_controlword,
                                         bool reset_fault) noexcept {
  switch (state) {
    case DriveState::switch_on_disabled: return shutdown;
    case DriveState::ready_to_switch_on: return switch_on;
    case DriveState::switched_on:
    case DriveState::operation_enabled: return enable_operation;
    case DriveState::fault: return reset_fault ? fault_reset_controlword(last_controlword) : disable_voltage;
    case DriveState::quick_stop_active:  // left by way of switch_on_disabled
    case DriveState::not_ready_to_switch_on:
    case DriveState::fault_reaction_active:
    case DriveState::unknown: break;
  }
  return disable_voltage;
}

/// Largest torque of 6071h, in per mille of the rated torque 6076h: 16 bits, symmetric.
inline constexpr double max_torque_per_mille = 32767;

/// Returns round(1000 tau / tau_rated), clamped to +-1000 tau_max / tau_rated and +-max_torque_per_mille.
/// Returns 0 for NaN or limits that are not positive.
inline std::int16_t torque_to_per_mille(double torque_Nm, double torque_rated_Nm,
                                        double torque_max_Nm) noexcept {
  if (!(torque_rated_Nm > 0) || !(torque_max_Nm > 0)) return 0;
  const double max_per_mille = std::min(1000 * torque_max_Nm / torque_rated_Nm, max_torque_per_mille);
  const auto limit = static_cast<std::int16_t>(max_per_mille);
  const auto low = static_cast<std::int16_t>(-limit);
  return saturate_to<std::int16_t>(1000 * torque_Nm / torque_rated_Nm, low, limit);
}

constexpr double torque_from_per_mille(std::int16_t per_mille, double torque_rated_Nm) noexcept {
  return per_mille * torque_rated_Nm / 1000;
}

/// RPDO1, host to drive.
struct Command {
  std::uint16_t controlword = disable_voltage;
  std::int16_t target_torque_per_mille = 0;
};
inline constexpr std::uint8_t command_size = 4;

/// TPDO1, drive to host, every n-th SYNC.
struct Status {
  std::uint16_t statusword = 0;
  std::int32_t position_counts = 0;
  std::int16_t actual_torque_per_mille = 0;
};
inline constexpr std::uint8_t status_size = 8;

/// TPDO2, drive to host, by its event timer.
struct Event {
  std::int32_t velocity_counts_per_s = 0;
  std::int8_t mode = 0;
  std::uint16_t error_code = 0;
};
inline constexpr std::uint8_t event_size = 7;

constexpr CanFrame make_command(std::uint8_t node, const Command& command) noexcept {
  CanFrame frame{.id = canopen::rpdo_cob_id(1, node), .size = command_size};
  ByteWriter(frame.data).put(command.controlword).put(command.target_torque_per_mille);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_command(const CanFrame& frame, std::uint8_t node,
                                                  Command& out) noexcept {
  const ParseResult result = canopen::check_message(frame, canopen::rpdo_cob_id(1, node), command_size);
  if (result == ParseResult::ok)
    ByteReader(frame.bytes()).get(out.controlword).get(out.target_torque_per_mille);
  return result;
}

constexpr CanFrame make_status(std::uint8_t node, const Status& status) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(1, node), .size = status_size};
  ByteWriter(frame.data)
      .put(status.statusword)
      .put(status.position_counts)
      .put(status.actual_torque_per_mille);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_status(const CanFrame& frame, std::uint8_t node,
                                                 Status& out) noexcept {
  const ParseResult result = canopen::check_message(frame, canopen::tpdo_cob_id(1, node), status_size);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(out.statusword).get(out.position_counts).get(out.actual_torque_per_mille);
  return result;
}

constexpr CanFrame make_event(std::uint8_t node, const Event& event) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(2, node), .size = event_size};
  ByteWriter(frame.data).put(event.velocity_counts_per_s).put(event.mode).put(event.error_code);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_event(const CanFrame& frame, std::uint8_t node,
                                                Event& out) noexcept {
  const ParseResult result = canopen::check_message(frame, canopen::tpdo_cob_id(2, node), event_size);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(out.velocity_counts_per_s).get(out.mode).get(out.error_code);
  return result;
}

}  // namespace godobject::cia402
