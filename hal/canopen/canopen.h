// CANopen (CiA 301): identifiers, network management, heartbeat, SYNC and emergency messages.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "hal/base/codec.h"
#include "hal/can/filter.h"

namespace godobject::canopen {

inline constexpr std::uint8_t max_node_id = 127;  // nodes are 1..127; 0 addresses all of them

// COB-IDs of the predefined connection set. PDO numbers: 1..4.
inline constexpr std::uint32_t nmt_cob_id = 0x000;
inline constexpr std::uint32_t sync_cob_id = 0x080;
constexpr std::uint32_t emcy_cob_id(std::uint8_t node) noexcept { return 0x080u + node; }
constexpr std::uint32_t tpdo_cob_id(int number, std::uint8_t node) noexcept {
  return 0x080u + 0x100u * static_cast<std::uint32_t>(number) + node;
}
constexpr std::uint32_t rpdo_cob_id(int number, std::uint8_t node) noexcept {
  return 0x100u + 0x100u * static_cast<std::uint32_t>(number) + node;
}
constexpr std::uint32_t heartbeat_cob_id(std::uint8_t node) noexcept { return 0x700u + node; }

enum class NmtCommand : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  enter_pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

enum class NmtState : std::uint8_t { boot_up = 0, stopped = 4, operational = 5, pre_operational = 127 };

// Emergency error codes sent or handled by name.
inline constexpr std::uint16_t emcy_no_error = 0x0000;
inline constexpr std::uint16_t emcy_generic_error = 0x1000;
inline constexpr std::uint16_t emcy_pdo_too_short = 0x8210;
inline constexpr std::uint16_t emcy_pdo_too_long = 0x8220;
inline constexpr std::uint16_t emcy_rpdo_timeout = 0x8250;

struct Nmt {
  NmtCommand command = NmtCommand::start;
  std::uint8_t node = 0;
};

struct Heartbeat {
  std::uint8_t node = 0;
  NmtState state = NmtState::boot_up;
};

struct Emergency {
  std::uint8_t node = 0;
  std::uint16_t error_code = emcy_no_error;
  std::uint8_t error_register = 0;  // object 1001h: bit 0 generic, bit 4 communication
  std::array<std::uint8_t, 5> vendor{};
};

/// True for a classic data frame with 11-bit identifier, the only kind that CANopen (CiA 301) uses.
constexpr bool is_canopen(const CanFrame& frame) noexcept {
  return !frame.extended && !frame.remote && !frame.fd;
}

/// Returns the node of a frame in the predefined connection set: the low seven bits of the COB-ID. Returns 0
/// if the frame belongs to no node.
constexpr std::uint8_t sender(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  return is_canopen(frame) ? static_cast<std::uint8_t>(frame.id & max_node_id) : std::uint8_t{0};
}

/// Filters all frames from and to a node: the low seven bits, any function code.
inline std::vector<CanFilter> filters(std::uint8_t node) { return {{.id = node, .mask = max_node_id}}; }

/// Returns the node that an RPDO1 addresses; 0 if the frame is no RPDO1.
constexpr std::uint8_t commanded(const CanFrame& frame) noexcept GODOBJECT_NONBLOCKING {
  return is_canopen(frame) && (frame.id & ~std::uint32_t{max_node_id}) == rpdo_cob_id(1, 0)
             ? static_cast<std::uint8_t>(frame.id & max_node_id)
             : std::uint8_t{0};
}

/// COB-ID of the command message: RPDO1.
constexpr std::uint32_t command_id(std::uint8_t node) noexcept { return rpdo_cob_id(1, node); }

/// True for frames that only the network master sends: NMT, SYNC and the heartbeat of its node id.
constexpr bool is_from_master(const CanFrame& frame, std::uint8_t master) noexcept {
  return is_canopen(frame) &&
         (frame.id == nmt_cob_id || frame.id == sync_cob_id || frame.id == heartbeat_cob_id(master));
}

/// Checks that a frame has COB-ID `cob_id` and exactly `size` bytes.
[[nodiscard]] constexpr ParseResult check_message(const CanFrame& frame, std::uint32_t cob_id,
                                                  std::size_t size) noexcept {
  if (!is_canopen(frame) || frame.id != cob_id) return ParseResult::other_message;
  return check_size(frame.size, size);
}

/// Makes a SYNC without counter (1019h = 0).
constexpr CanFrame make_sync() noexcept { return {.id = sync_cob_id}; }

/// Makes a SYNC with a counter byte, 1..240.
constexpr CanFrame make_sync(std::uint8_t counter) noexcept {
  CanFrame frame{.id = sync_cob_id, .size = 1};
  frame.data[0] = counter;
  return frame;
}

/// Parses SYNC with or without counter; counter: 0 without.
[[nodiscard]] constexpr ParseResult parse_sync(const CanFrame& frame, std::uint8_t& counter) noexcept {
  if (!is_canopen(frame) || frame.id != sync_cob_id) return ParseResult::other_message;
  if (frame.size > 1) return ParseResult::too_long;
  counter = frame.size == 1 ? frame.data[0] : std::uint8_t{0};
  return ParseResult::ok;
}

/// Makes an NMT command. node: node id; 0 addresses all nodes.
constexpr CanFrame make_nmt(NmtCommand command, std::uint8_t node) noexcept {
  CanFrame frame{.id = nmt_cob_id, .size = 2};
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = node;
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_nmt(const CanFrame& frame, Nmt& out) noexcept {
  const ParseResult result = check_message(frame, nmt_cob_id, 2);
  if (result != ParseResult::ok) return result;
  if (frame.data[1] > max_node_id) return ParseResult::bad_value;
  const auto command = static_cast<NmtCommand>(frame.data[0]);
  switch (command) {
    case NmtCommand::start:
    case NmtCommand::stop:
    case NmtCommand::enter_pre_operational:
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      out = {.command = command, .node = frame.data[1]};
      return ParseResult::ok;
  }
  return ParseResult::bad_value;
}

/// Makes a heartbeat; with state boot_up, the boot-up message.
constexpr CanFrame make_heartbeat(std::uint8_t node, NmtState state) noexcept {
  CanFrame frame{.id = heartbeat_cob_id(node), .size = 1};
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

/// Parses a heartbeat of any node 1..127. Returns bad_value for a state byte with bit 7 set (toggle of node
/// guarding).
[[nodiscard]] constexpr ParseResult parse_heartbeat(const CanFrame& frame, Heartbeat& out) noexcept {
  if (!is_canopen(frame) || frame.id <= heartbeat_cob_id(0) || frame.id > heartbeat_cob_id(max_node_id)) {
    return ParseResult::other_message;
  }
  const ParseResult result = check_size(frame.size, 1);
  if (result != ParseResult::ok) return result;
  const auto state = static_cast<NmtState>(frame.data[0]);
  switch (state) {
    case NmtState::boot_up:
    case NmtState::stopped:
    case NmtState::operational:
    case NmtState::pre_operational:
      out = {.node = static_cast<std::uint8_t>(frame.id - heartbeat_cob_id(0)), .state = state};
      return ParseResult::ok;
  }
  return ParseResult::bad_value;
}

/// Makes an emergency message: code (16 bits), register, five vendor-specific bytes.
constexpr CanFrame make_emergency(const Emergency& emergency) noexcept {
  CanFrame frame{.id = emcy_cob_id(emergency.node), .size = 8};
  ByteWriter(frame.data).put(emergency.error_code).put(emergency.error_register);
  std::ranges::copy(emergency.vendor, frame.data.begin() + 3);
  return frame;
}

/// Parses an emergency message of any node 1..127. Missing bytes at the end count as 0. A message without a
/// whole code yields that of a generic error.
[[nodiscard]] constexpr ParseResult parse_emergency(const CanFrame& frame, Emergency& out) noexcept {
  if (!is_canopen(frame) || frame.id <= emcy_cob_id(0) || frame.id > emcy_cob_id(max_node_id)) {
    return ParseResult::other_message;
  }
  constexpr std::size_t whole = 8, code_end = 2;
  if (frame.size > whole) return ParseResult::too_long;
  std::array<std::uint8_t, whole> bytes{};
  std::copy_n(frame.data.begin(), frame.size, bytes.begin());
  out.node = static_cast<std::uint8_t>(frame.id - emcy_cob_id(0));
  ByteReader(bytes).get(out.error_code).get(out.error_register);
  if (frame.size < code_end) out.error_code = emcy_generic_error;
  std::copy_n(bytes.begin() + 3, out.vendor.size(), out.vendor.begin());
  return ParseResult::ok;
}

}  // namespace godobject::canopen
