// Service data objects (CiA 301 7.2.4.3): expedited and segmented transfers, both directions. Block transfer
// is not supported. Each message has eight bytes; some servers omit unused bytes at the end. The direction of
// a message determines the meaning of its first byte, the command.
#pragma once

#include <algorithm>

#include "hal/canopen/message.h"
#include "hal/canopen/object.h"

namespace godobject::sdo {

constexpr std::uint32_t request_cob_id(std::uint8_t node) noexcept { return 0x600u + node; }
constexpr std::uint32_t response_cob_id(std::uint8_t node) noexcept { return 0x580u + node; }

enum class AbortCode : std::uint32_t {
  none = 0,
  toggle_not_alternated = 0x0503'0000,
  timed_out = 0x0504'0000,
  unknown_command = 0x0504'0001,
  out_of_memory = 0x0504'0005,
  unsupported_access = 0x0601'0000,
  write_only = 0x0601'0001,
  read_only = 0x0601'0002,
  no_object = 0x0602'0000,
  not_mappable = 0x0604'0041,
  pdo_length_exceeded = 0x0604'0042,
  wrong_length = 0x0607'0010,
  too_long = 0x0607'0012,
  too_short = 0x0607'0013,
  no_sub_index = 0x0609'0011,
  invalid_value = 0x0609'0030,
  value_too_high = 0x0609'0031,
  value_too_low = 0x0609'0032,
  general = 0x0800'0000,
  device_state = 0x0800'0022,
};

/// Returns the meaning of the code in CiA 301; for vendor codes "not in CiA 301: see the device's manual".
const char* text_of(AbortCode code) noexcept;

using canopen::make_frame;
using canopen::Message;
using canopen::ObjectAddress;
using canopen::parse_frame;

inline constexpr std::size_t expedited_capacity = 4;
inline constexpr std::size_t segment_capacity = 7;

/// Command specifier: bits 7..5 of the first byte.
enum class Request : std::uint8_t {
  download_segment = 0,
  initiate_download = 1,  // client writes
  initiate_upload = 2,    // client reads
  upload_segment = 3,
  abort = 4,
};
enum class Response : std::uint8_t {
  upload_segment = 0,
  download_segment = 1,
  initiate_upload = 2,
  initiate_download = 3,
  abort = 4,
};
constexpr std::uint8_t command_of(const Message& message) noexcept {
  return static_cast<std::uint8_t>(message[0] >> 5);
}
constexpr ObjectAddress address_of(const Message& message) noexcept {
  return {static_cast<std::uint16_t>(message[1] | message[2] << 8), message[3]};
}
constexpr bool toggle_of(const Message& message) noexcept { return (message[0] & 0x10u) != 0; }

namespace detail {
template <class Command>
constexpr Message addressed(Command command, std::uint8_t flags, ObjectAddress address,
                            std::uint32_t data = 0) noexcept {
  Message message{};
  const auto first = static_cast<std::uint8_t>(static_cast<unsigned>(command) << 5 | flags);
  ByteWriter(message).put(first).put(address.index).put(address.sub).put(data);
  return message;
}
}  // namespace detail

/// Makes a message without data: initiate_upload of a client, initiate_download of a server.
template <class Command>
constexpr Message make_plain(Command command, ObjectAddress address) noexcept {
  return detail::addressed(command, 0, address);
}

/// Makes an expedited message with 1 to 4 bytes: Request::initiate_download, Response::initiate_upload.
template <class Command>
constexpr Message make_expedited(Command command, ObjectAddress address,
                                 std::span<const std::uint8_t> data) noexcept {
  const auto unused = static_cast<unsigned>(expedited_capacity - data.size());
  Message message = detail::addressed(command, static_cast<std::uint8_t>(unused << 2 | 0x03u), address);
  std::ranges::copy(data, message.begin() + 4);
  return message;
}

/// Announces `size` bytes that follow in segments.
template <class Command>
constexpr Message make_announcement(Command command, ObjectAddress address, std::uint32_t size) noexcept {
  return detail::addressed(command, 0x01, address, size);
}

/// Makes a segment of up to 7 bytes: Request::download_segment, Response::upload_segment.
template <class Command>
constexpr Message make_segment(Command command, bool toggle, bool last,
                               std::span<const std::uint8_t> data) noexcept {
  const auto unused = static_cast<unsigned>(segment_capacity - data.size());
  Message message{};
  message[0] = static_cast<std::uint8_t>(static_cast<unsigned>(command) << 5 | (toggle ? 0x10u : 0u) |
                                         unused << 1 | (last ? 1u : 0u));
  std::ranges::copy(data, message.begin() + 1);
  return message;
}

/// Makes a segment request or confirmation: Request::upload_segment, Response::download_segment.
template <class Command>
constexpr Message make_turn(Command command, bool toggle) noexcept {
  return {static_cast<std::uint8_t>(static_cast<unsigned>(command) << 5 | (toggle ? 0x10u : 0u))};
}

constexpr Message make_abort(ObjectAddress address, AbortCode code) noexcept {
  return detail::addressed(Request::abort, 0, address, static_cast<std::uint32_t>(code));
}
constexpr AbortCode abort_code_of(const Message& message) noexcept {
  std::uint32_t code = 0;
  ByteReader(std::span(message).subspan(4)).get(code);
  return static_cast<AbortCode>(code);
}

/// Parses an answer of a node, at least 1 byte long. Bytes of `out` beyond `size` are 0.
[[nodiscard]] constexpr ParseResult parse_response(const CanFrame& frame, std::uint8_t node, Message& out,
                                                   std::size_t& size) noexcept {
  if (!canopen::is_canopen(frame) || frame.id != response_cob_id(node)) return ParseResult::other_message;
  if (frame.size == 0) return ParseResult::too_short;
  if (frame.size > out.size()) return ParseResult::too_long;
  out = {};
  size = frame.size;
  std::copy_n(frame.data.begin(), size, out.begin());
  return ParseResult::ok;
}

/// Size information in a message that initiates a transfer.
struct Initiation {
  bool expedited = false;
  bool size_given = false;
  std::uint32_t size = 0;  // bytes; 4 for an expedited transfer without size
};
constexpr Initiation initiation_of(const Message& message) noexcept {
  Initiation out{.expedited = (message[0] & 0x02u) != 0, .size_given = (message[0] & 0x01u) != 0};
  if (out.expedited) {
    out.size = out.size_given ? 4u - ((message[0] >> 2) & 0x03u) : 4u;
  } else if (out.size_given) {
    ByteReader(std::span(message).subspan(4)).get(out.size);
  }
  return out;
}
constexpr std::span<const std::uint8_t> expedited_data(const Message& message) noexcept {
  return std::span(message).subspan(4, initiation_of(message).size);
}

constexpr bool is_last_segment(const Message& message) noexcept { return (message[0] & 0x01u) != 0; }
constexpr std::span<const std::uint8_t> segment_data(const Message& message) noexcept {
  return std::span(message).subspan(1, segment_capacity - ((message[0] >> 1) & 0x07u));
}

}  // namespace godobject::sdo
