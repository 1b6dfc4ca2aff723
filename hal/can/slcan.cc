#include "hal/can/slcan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/base/format.h"

namespace godobject::slcan {
namespace {

constexpr std::size_t max_data = 8;
constexpr std::size_t timestamp_digits = 4;
constexpr char hex_digits[] = "0123456789ABCDEF";

int digit(char c, int base) noexcept {
  int value = -1;
  if (c >= '0' && c <= '9') {
    value = c - '0';
  } else if (c >= 'A' && c <= 'F') {
    value = c - 'A' + 10;
  } else if (c >= 'a' && c <= 'f') {
    value = c - 'a' + 10;
  }
  return value < base ? value : -1;
}

/// Parses and removes the first `count` digits of `text`.
bool take(std::string_view& text, std::size_t count, int base, std::uint32_t& value) noexcept {
  if (text.size() < count) return false;
  std::uint32_t number = 0;
  for (const char c : part_of(text, 0, count)) {
    const int d = digit(c, base);
    if (d < 0) return false;
    number = number * static_cast<std::uint32_t>(base) + static_cast<std::uint32_t>(d);
  }
  text.remove_prefix(count);
  value = number;
  return true;
}

bool is_frame(char command) noexcept {
  return command == 't' || command == 'T' || command == 'r' || command == 'R';
}

bool is_fd(char command) noexcept {
  return command == 'd' || command == 'D' || command == 'b' || command == 'B';
}

/// Parses a frame. text: begins with t, T, r or R; the text after the data remains in it.
ParseResult take_frame(std::string_view& text, CanFrame& frame) noexcept {
  const char command = text.front();  // cppcheck-suppress containerOutOfBounds
  frame.extended = command == 'T' || command == 'R';
  frame.remote = command == 'r' || command == 'R';
  const std::size_t id_digits = frame.extended ? 8 : 3;
  text.remove_prefix(1);
  if (text.size() < id_digits + 1) return ParseResult::too_short;
  std::uint32_t size = 0;
  if (!take(text, id_digits, 16, frame.id) || !take(text, 1, 16, size) || size > max_data)
    return ParseResult::bad_value;
  frame.size = static_cast<std::uint8_t>(size);
  if (!is_valid(frame)) return ParseResult::bad_value;
  if (frame.remote) return ParseResult::ok;
  if (text.size() < std::size_t{2} * frame.size) return ParseResult::too_short;
  for (std::size_t i = 0; i < frame.size; ++i) {
    std::uint32_t byte = 0;
    if (!take(text, 2, 16, byte)) return ParseResult::bad_value;
    frame.data[i] = static_cast<std::uint8_t>(byte);
  }
  return ParseResult::ok;
}

ParseResult parse_received_frame(std::string_view text, Reply& reply) noexcept {
  reply.kind = ReplyKind::frame;
  const ParseResult result = take_frame(text, reply.frame);
  if (result != ParseResult::ok || text.empty()) return result;
  std::uint32_t milliseconds = 0;
  if (text.size() != timestamp_digits)
    return text.size() < timestamp_digits ? ParseResult::too_short : ParseResult::too_long;
  if (!take(text, timestamp_digits, 16, milliseconds)) return ParseResult::bad_value;
  reply.timestamp_ms = static_cast<std::uint16_t>(milliseconds);
  return ParseResult::ok;
}

/// True if `text`, beginning with d, D, b or B, is a whole CAN FD frame, with or without time stamp.
bool is_fd_frame(std::string_view text) noexcept {
  constexpr std::array<std::size_t, 16> sizes{0, 1,  2,  3,  4,  5,  6,  7,
                                              8, 12, 16, 20, 24, 32, 48, 64};  // by DLC
  CanFrame frame{.extended = text.front() == 'D' || text.front() == 'B'};
  std::uint32_t dlc = 0, byte = 0;
  text.remove_prefix(1);
  if (!take(text, frame.extended ? 8 : 3, 16, frame.id) || !take(text, 1, 16, dlc) || !is_valid(frame))
    return false;
  const std::size_t data_digits = 2 * sizes[dlc];
  if (text.size() != data_digits && text.size() != data_digits + timestamp_digits) return false;
  while (!text.empty())
    if (!take(text, 1, 16, byte)) return false;
  return true;
}

/// True if a line too long for a classic frame begins like a CAN FD frame.
bool begins_fd_frame(std::string_view text) noexcept {
  std::uint32_t digit = 0;
  if (!is_fd(text.front())) return false;
  text.remove_prefix(1);
  while (!text.empty())
    if (!take(text, 1, 16, digit)) return false;
  return true;
}

/// Parses "w096100": state, then the receive and transmit error counters, decimal.
ParseResult parse_state(std::string_view text, Reply& reply) noexcept {
  constexpr std::size_t size = 1 + 3 + 3;
  if (text.size() != size) return check_size(text.size(), size);
  switch (text.front()) {
    case 'a': reply.report.state = BusState::error_active; break;
    case 'w': reply.report.state = BusState::error_warning; break;
    case 'p': reply.report.state = BusState::error_passive; break;
    case 'b': reply.report.state = BusState::bus_off; break;
    default: return ParseResult::bad_value;
  }
  text.remove_prefix(1);
  std::uint32_t receive = 0, transmit = 0;
  if (!take(text, 3, 10, receive) || !take(text, 3, 10, transmit)) return ParseResult::bad_value;
  // The transmit error counter exceeds 255 at bus-off; the report clamps it like a controller's register.
  constexpr std::uint32_t max_counter = 255;
  reply.report.counters = {.transmit = static_cast<std::uint8_t>(std::min(transmit, max_counter)),
                           .receive = static_cast<std::uint8_t>(std::min(receive, max_counter))};
  reply.kind = ReplyKind::error_report;
  return ParseResult::ok;
}

BusError error_of(char letter) noexcept {
  switch (letter) {
    case 'a': return BusError::acknowledge;
    case 'b':
    case 'B': return BusError::bit;
    case 'c': return BusError::crc;
    case 'f': return BusError::form;
    case 's': return BusError::stuff;
    case 'o': return BusError::receive_overflow;
    case 'O': return BusError::transmit_overflow;
    default: return BusError::none;
  }
}

/// Parses "2bs": number of errors and their letters. Reports the first.
ParseResult parse_errors(std::string_view text, Reply& reply) noexcept {
  std::uint32_t count = 0;
  if (text.empty()) return ParseResult::too_short;
  if (!take(text, 1, 10, count) || count == 0) return ParseResult::bad_value;
  if (text.size() != count) return check_size(text.size(), count);
  if (std::ranges::any_of(text, [](char c) { return error_of(c) == BusError::none; }))
    return ParseResult::bad_value;
  reply.report.error = error_of(text.front());
  reply.kind = ReplyKind::error_report;
  return ParseResult::ok;
}

ParseResult parse_flags(std::string_view text, Reply& reply) noexcept {
  std::uint32_t flags = 0;
  if (text.size() != 2) return check_size(text.size(), 2);
  if (!take(text, 2, 16, flags)) return ParseResult::bad_value;
  reply.flags = static_cast<std::uint8_t>(flags);
  reply.kind = ReplyKind::flags;
  return ParseResult::ok;
}

ParseResult parse_reply_into(std::string_view line, Reply& reply) noexcept {
  if (line.empty()) return ParseResult::ok;
  if (is_frame(line.front())) return parse_received_frame(line, reply);
  if (is_fd(line.front())) {
    reply.kind = ReplyKind::fd_frame;
    return is_fd_frame(line) ? ParseResult::ok : ParseResult::bad_value;
  }
  const std::string_view rest = part_of(line, 1);
  switch (line.front()) {
    case '\a': reply.kind = ReplyKind::refused; return check_size(rest.size(), 0);
    case 'z':
    case 'Z': reply.kind = ReplyKind::taken; return check_size(rest.size(), 0);
    case 'V':
    case 'N': reply.kind = ReplyKind::identity; return ParseResult::ok;
    case 'F': return parse_flags(rest, reply);
    case 's': return parse_state(rest, reply);
    case 'e': return parse_errors(rest, reply);
    default: return ParseResult::other_message;
  }
}

ParseResult parse_value(std::string_view text, std::uint32_t max, Request& request) noexcept {
  std::uint32_t value = 0;
  if (text.size() != 1) return check_size(text.size(), 1);
  if (!take(text, 1, 10, value) || value > max) return ParseResult::bad_value;
  request.value = static_cast<std::uint8_t>(value);
  return ParseResult::ok;
}

ParseResult parse_request_into(std::string_view line, Request& request) noexcept {
  if (line.empty()) return ParseResult::too_short;
  if (is_frame(line.front())) {
    request.kind = RequestKind::send;
    const ParseResult result = take_frame(line, request.frame);
    return result == ParseResult::ok ? check_size(line.size(), 0) : result;
  }
  const std::string_view rest = part_of(line, 1);
  switch (line.front()) {
    case 'S':
      request.kind = RequestKind::set_bit_rate;
      return parse_value(rest, bit_rates.size() - 1, request);
    case 'Z': request.kind = RequestKind::timestamps; return parse_value(rest, 1, request);
    case 'O': request.kind = RequestKind::open; break;
    case 'L': request.kind = RequestKind::listen; break;
    case 'C': request.kind = RequestKind::close; break;
    case 'F': request.kind = RequestKind::flags; break;
    case 'V': request.kind = RequestKind::version; break;
    case 'N': request.kind = RequestKind::serial_number; break;
    default: return ParseResult::other_message;
  }
  return check_size(rest.size(), 0);
}

}  // namespace

std::string_view bit_rate_command(double bit_rate) noexcept {
  static constexpr std::array<std::string_view, bit_rates.size()> commands{
      "S0\r", "S1\r", "S2\r", "S3\r", "S4\r", "S5\r", "S6\r", "S7\r", "S8\r"};
  for (std::size_t i = 0; i < bit_rates.size(); ++i)
    if (std::abs(bit_rate - bit_rates[i]) < 0.5) return commands[i];
  return {};
}

std::size_t format_frame(const CanFrame& frame, std::span<char> out,
                         std::optional<std::uint16_t> timestamp_ms) noexcept {
  if (frame.fd || !is_valid(frame)) return 0;
  const std::size_t id_digits = frame.extended ? 8 : 3;
  const std::size_t data_bytes = frame.remote ? 0 : frame.size;
  if (out.size() < 1 + id_digits + 1 + 2 * data_bytes + (timestamp_ms ? timestamp_digits : 0) + 1) return 0;
  std::size_t n = 0;
  const auto put = [&](std::uint32_t value, std::size_t digits) {
    for (std::size_t i = digits; i-- > 0;) out[n++] = hex_digits[value >> (4 * i) & 0xFu];
  };
  out[n++] = frame.remote ? (frame.extended ? 'R' : 'r') : (frame.extended ? 'T' : 't');
  put(frame.id, id_digits);
  put(frame.size, 1);
  for (std::size_t i = 0; i < data_bytes; ++i) put(frame.data[i], 2);
  if (timestamp_ms) put(*timestamp_ms, timestamp_digits);
  out[n++] = '\r';
  return n;
}

ParseResult parse_reply(std::string_view line, Reply& out) noexcept {
  Reply reply;
  const ParseResult result = parse_reply_into(line, reply);
  if (result == ParseResult::ok) out = reply;
  return result;
}

ParseResult parse_request(std::string_view line, Request& out) noexcept {
  Request request;
  const ParseResult result = parse_request_into(line, request);
  if (result == ParseResult::ok) out = request;
  return result;
}

bool LineReader::put(std::uint8_t byte) noexcept {
  if (complete_) size_ = 0;
  complete_ = false;
  const char c = static_cast<char>(byte);
  const char last_end = std::exchange(end_, '\0');
  if (c == '\a') {
    if (size_ > 0) ++num_cut_;
    text_[0] = c;
    size_ = 1;
    overlong_ = false;
    return complete_ = true;
  }
  if (c == '\r' || c == '\n') {
    if (last_end != '\0' && last_end != c) return false;  // second character of a CR LF pair
    end_ = c;
    complete_ = !overlong_;
    if (overlong_) size_ = 0;
    overlong_ = false;
    return complete_;
  }
  if (size_ == text_.size()) {
    if (!overlong_ && begins_fd_frame(line())) {
      ++num_fd_;
    } else if (!overlong_) {
      ++num_overlong_;
      overlong_begin_ = text_;
    }
    overlong_ = true;
    return false;
  }
  text_[size_++] = c;
  return false;
}

}  // namespace godobject::slcan
