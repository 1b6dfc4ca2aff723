#include "hal/can/candump.h"

#include <algorithm>
#include <limits>

#include "hal/base/format.h"

namespace godobject {
namespace {

constexpr std::size_t max_interface_length = 15;  // Linux: IFNAMSIZ - 1
constexpr std::uint32_t error_frame_flag = 0x20000000;
constexpr std::uint32_t fd_bit_rate_switch_flag = 1;
constexpr std::uint32_t fd_error_state_flag = 2;
// CANFD_FDF: set by Linux since 5.14; candump writes the flags it receives.
constexpr std::uint32_t fd_format_flag = 4;
constexpr std::int64_t max_seconds = std::numeric_limits<std::int64_t>::max() / 1'000'000'000 - 1;

bool is_interface(std::string_view name) {
  return !name.empty() && name.size() <= max_interface_length &&
         name.find_first_of(" \t\r\n") == std::string::npos;
}

/// Returns the value of a digit, at most 15; 16 for any other character.
constexpr std::uint64_t digit(char c) noexcept {
  if (c >= '0' && c <= '9') return static_cast<std::uint64_t>(c - '0');
  const char lower = c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower >= 'a' && lower <= 'f' ? static_cast<std::uint64_t>(lower - 'a' + 10) : 16;
}

/// Parses the whole of `text` as an unsigned number. std::from_chars has a static local table, so the loop
/// cannot call it (core/nonblocking.h).
template <class T>
bool to_number(std::string_view text, std::uint64_t base, T& value) noexcept {
  constexpr auto largest = static_cast<std::uint64_t>(std::numeric_limits<T>::max());
  std::uint64_t number = 0;
  for (const char c : text) {
    const std::uint64_t d = digit(c);
    if (d >= base || number > (largest - d) / base) return false;
    number = base * number + d;
  }
  if (!text.empty()) value = static_cast<T>(number);
  return !text.empty();
}

class LineWriter {
 public:
  explicit LineWriter(std::span<char> out) : out_(out) {}

  void text(std::string_view s) {
    fits_ = fits_ && out_.size() - length_ >= s.size();
    if (!fits_) return;
    std::ranges::copy(s, out_.begin() + static_cast<std::ptrdiff_t>(length_));
    length_ += s.size();
  }

  void digits(std::uint64_t value, std::size_t width, unsigned base) {
    std::array<char, 20> reversed{};
    std::size_t n = 0;
    for (; value != 0 || n < width; value /= base) reversed[n++] = "0123456789ABCDEF"[value % base];
    while (n > 0) text({&reversed[--n], 1});
  }

  bool fits() const { return fits_; }
  std::size_t length() const { return length_; }

 private:
  std::span<char> out_;
  std::size_t length_ = 0;
  bool fits_ = true;
};

/// Cuts `text` at the first `separator`. Returns the text before it and leaves the text after it.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view head = part_of(text, 0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return head;
}

/// Parses "(1631416514.717133)", or with nine digits of fraction.
bool parse_time(std::string_view text, Nanoseconds& t_ns) {
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return false;
  std::string_view fraction_text = part_of(text, 1, text.size() - 2);
  const std::string_view seconds_text = cut(fraction_text, '.');
  std::int64_t seconds = 0, fraction = 0;
  const bool nanoseconds = fraction_text.size() == 9;
  if ((fraction_text.size() != 6 && !nanoseconds) || !to_number(fraction_text, 10, fraction)) return false;
  if (!to_number(seconds_text, 10, seconds) || seconds > max_seconds) return false;
  t_ns = seconds * 1'000'000'000 + fraction * (nanoseconds ? 1 : 1000);
  return true;
}

CandumpResult parse_identifier(std::string_view text, CanFrame& frame) {
  constexpr CandumpResult bad = CandumpResult::bad_identifier;
  if ((text.size() != 3 && text.size() != 8) || !to_number(text, 16, frame.id)) return bad;
  frame.extended = text.size() == 8;
  if (frame.extended && (frame.id & ~0x1FFF'FFFFu) == error_frame_flag) return CandumpResult::error_frame;
  return is_valid({.id = frame.id, .extended = frame.extended}) ? CandumpResult::ok : bad;
}

bool parse_bytes(std::string_view text, CanFrame& frame) {
  if (text.size() % 2 != 0 || text.size() > 2 * frame.data.size()) return false;
  frame.size = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i) {
    if (!to_number(part_of(text, 2 * i, 2), 16, frame.data[i])) return false;
  }
  return true;
}

/// Removes a suffix "_9" to "_F" from `text`: a DLC above 8 of a classic frame, which has 8 bytes then.
/// Returns false for any other suffix.
bool take_long_dlc(std::string_view& text, bool& has_long_dlc) {
  const std::size_t at = text.find('_');
  std::uint32_t dlc = 0;
  has_long_dlc = at != std::string_view::npos;
  if (!has_long_dlc) return true;
  const bool is_long = text.size() == at + 2 && to_number(part_of(text, at + 1), 16, dlc) && dlc > 8;
  text = part_of(text, 0, at);
  return is_long;
}

/// Parses the text after the first '#'.
bool parse_body(std::string_view text, CanFrame& frame) {
  bool has_long_dlc = false;
  if (!take_long_dlc(text, has_long_dlc)) return false;
  if (text.starts_with('#')) {
    std::uint32_t flags = 0;
    if (text.size() < 2 || !to_number(part_of(text, 1, 1), 16, flags)) return false;
    if ((flags & ~(fd_bit_rate_switch_flag | fd_error_state_flag | fd_format_flag)) != 0) return false;
    frame.fd = true;
    frame.bit_rate_switch = (flags & fd_bit_rate_switch_flag) != 0;
    text.remove_prefix(2);
  }
  if (!frame.fd && text.starts_with('R')) {
    frame.remote = true;
    const bool has_size = text.size() == 2 && to_number(part_of(text, 1), 10, frame.size) && is_valid(frame);
    if (text.size() != 1 && !has_size) return false;
  } else if (!parse_bytes(text, frame) || !is_valid(frame)) {
    return false;
  }
  return !has_long_dlc || (!frame.fd && frame.size == 8);
}

}  // namespace

CandumpResult format_candump(const ReceivedFrame& received, std::string_view interface, std::span<char> out,
                             std::size_t& length) noexcept {
  const CanFrame& frame = received.frame;
  if (received.t_ns < 0) return CandumpResult::bad_time;
  if (!is_interface(interface)) return CandumpResult::bad_interface;
  if (!is_valid({.id = frame.id, .extended = frame.extended})) return CandumpResult::bad_identifier;
  if (!is_valid(frame)) return CandumpResult::bad_data;

  const auto microseconds = static_cast<std::uint64_t>(received.t_ns / 1000);
  LineWriter line(out);
  line.text("(");
  line.digits(microseconds / 1'000'000, 10, 10);
  line.text(".");
  line.digits(microseconds % 1'000'000, 6, 10);
  line.text(") ");
  line.text(interface);
  line.text(" ");
  line.digits(frame.id, frame.extended ? 8 : 3, 16);
  line.text("#");
  if (frame.fd) {
    line.text("#");
    line.digits(frame.bit_rate_switch ? fd_bit_rate_switch_flag : 0, 1, 16);
  }
  if (frame.remote) {
    line.text("R");
    if (frame.size > 0) line.digits(frame.size, 1, 10);
  } else {
    for (const std::uint8_t byte : frame.bytes()) line.digits(byte, 2, 16);
  }
  if (!line.fits()) return CandumpResult::buffer_too_small;
  length = line.length();
  return CandumpResult::ok;
}

CandumpResult parse_candump(std::string_view line, ReceivedFrame& received,
                            std::string_view& interface) noexcept {
  if (!line.starts_with('(')) return CandumpResult::ignored;
  line = part_of(line, 0, line.find_first_of("\r\n"));
  ReceivedFrame parsed;
  if (!parse_time(cut(line, ' '), parsed.t_ns)) return CandumpResult::bad_time;
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  const std::string_view name = cut(line, ' ');
  const bool is_missing = line.empty() && name.find('#') != std::string_view::npos;
  if (!is_interface(name) || is_missing) return CandumpResult::bad_interface;
  std::string_view body = cut(line, ' ');
  const std::string_view direction = line;
  if (body.find('#') == std::string::npos) return CandumpResult::bad_data;
  const std::string_view identifier = cut(body, '#');
  const CandumpResult result = parse_identifier(identifier, parsed.frame);
  if (result != CandumpResult::ok) return result;
  if (!direction.empty() && direction != "R" && direction != "T") return CandumpResult::bad_data;
  if (!parse_body(body, parsed.frame)) return CandumpResult::bad_data;
  received = parsed;
  interface = name;
  return CandumpResult::ok;
}

}  // namespace godobject
