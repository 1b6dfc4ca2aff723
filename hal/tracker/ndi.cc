#include "hal/tracker/ndi.h"

#include <algorithm>

#include "hal/base/codec.h"
#include "hal/base/crc16.h"

namespace godobject::ndi {
namespace {

constexpr std::string_view hex_digits = "0123456789ABCDEF";
constexpr std::size_t crc_digits = 4;

/// Appends to a command; on overflow the command becomes empty.
class Appender {
 public:
  explicit Appender(Command& command) noexcept : command_(command) {}

  void add(std::string_view text) noexcept {
    if (text.size() > command_.data.size() - command_.size) fits_ = false;
    if (!fits_) return;
    std::ranges::copy(text, command_.data.begin() + static_cast<std::ptrdiff_t>(command_.size));
    command_.size += text.size();
  }
  void add_hex(std::uint32_t value, unsigned digits) noexcept {
    while (digits-- > 0) add(hex_digits.substr((value >> (4 * digits)) & 0xFu, 1));
  }
  void finish() noexcept {
    add_hex(crc16<crc16_arc>(command_.bytes()), crc_digits);
    add("\r");
    if (!fits_) command_.size = 0;
  }

 private:
  Command& command_;
  bool fits_ = true;
};

/// Returns the value of hexadecimal digits, upper case as sent by NDI.
std::optional<unsigned> from_hex(std::span<const std::uint8_t> digits) noexcept {
  unsigned value = 0;
  for (const std::uint8_t digit : digits) {
    const std::size_t at = hex_digits.find(static_cast<char>(digit));
    if (at == std::string_view::npos) return std::nullopt;
    value = value << 4 | static_cast<unsigned>(at);
  }
  return value;
}

}  // namespace

Command make_command(std::string_view name, std::string_view parameters) noexcept {
  Command command;
  Appender out(command);
  out.add(name);
  out.add(":");
  out.add(parameters);
  out.finish();
  return command;
}

Command make_handle_command(std::string_view name, std::uint8_t handle, std::string_view more) noexcept {
  Command command;
  Appender out(command);
  out.add(name);
  out.add(":");
  out.add_hex(handle, 2);
  out.add(more);
  out.finish();
  return command;
}

Command make_write_command(std::uint8_t handle, std::size_t address,
                           std::span<const std::uint8_t> file) noexcept {
  Command command;
  Appender out(command);
  out.add("PVWR:");
  out.add_hex(handle, 2);
  out.add_hex(static_cast<std::uint32_t>(address), 4);
  for (std::size_t i = address; i < address + block_size; ++i) out.add_hex(i < file.size() ? file[i] : 0u, 2);
  out.finish();
  return command;
}

std::optional<char> comm_digit(std::uint32_t baud) noexcept {
  switch (baud) {
    case 9600: return '0';
    case 14400: return '1';
    case 19200: return '2';
    case 38400: return '3';
    case 57600: return '4';
    case 115200: return '5';
    case 921600: return '6';
    case 1228739: return '7';
    case 230400: return 'A';
    default: return std::nullopt;
  }
}

ReplyReceiver::Event ReplyReceiver::push(std::uint8_t byte) noexcept {
  content_ = {};
  if (size_ == capacity) {
    size_ = 0;
    return Event::too_long;
  }
  data_[size_++] = byte;
  const bool binary = (data_[0] == 0xC4 || data_[0] == 0xC8) && (size_ < 2 || data_[1] == 0xA5);
  if (binary) return push_binary();
  return byte == '\r' ? finish_text() : Event::more;
}

ReplyReceiver::Event ReplyReceiver::finish_text() noexcept {
  const std::span<const std::uint8_t> all(data_.data(), size_ - 1);
  size_ = 0;
  if (all.size() < crc_digits) return Event::bad_crc;
  const std::span<const std::uint8_t> text = all.first(all.size() - crc_digits);
  if (from_hex(all.last(crc_digits)) != crc16<crc16_arc>(text)) return Event::bad_crc;
  content_ = text;
  return Event::text;
}

// C4 A5, size of 16 bits, or C8 A5, size of 32 bits; then a CRC of the header, the body, and its CRC.
ReplyReceiver::Event ReplyReceiver::push_binary() noexcept {
  const bool is_long = data_[0] == 0xC8;
  const std::size_t header_size = is_long ? 8 : 6;
  if (size_ < header_size) return Event::more;
  const std::span<const std::uint8_t> all(data_.data(), size_);
  std::uint16_t start = 0, short_size = 0, crc = 0;
  std::uint32_t body = 0;
  ByteReader in(all);
  in.get(start);
  if (is_long) in.get(body);
  else body = in.get(short_size).ok() ? short_size : 0;
  in.get(crc);
  const bool header_right = crc == crc16<crc16_arc>(all.first(header_size - 2));
  if (!header_right || body > capacity - header_size - 2) {
    size_ = 0;
    return header_right ? Event::too_long : Event::bad_crc;
  }
  if (size_ < header_size + body + 2) return Event::more;
  size_ = 0;
  ByteReader(all.last(2)).get(crc);
  const std::span<const std::uint8_t> bytes = all.subspan(header_size, body);
  if (crc != crc16<crc16_arc>(bytes)) return Event::bad_crc;
  content_ = bytes;
  return Event::binary;
}

TextReply classify(std::span<const std::uint8_t> text) noexcept {
  const auto begins = [&](std::string_view word) {
    return text.size() >= word.size() && std::ranges::equal(text.first(word.size()), word);
  };
  const auto code_after = [&](std::size_t at) {
    return text.size() == at + 2 ? from_hex(text.subspan(at, 2)) : std::nullopt;
  };
  if (text.size() == 4 && begins("OKAY")) return {.kind = ReplyKind::okay};
  if (text.size() == 5 && begins("RESET")) return {.kind = ReplyKind::reset};
  if (const auto code = code_after(5); begins("ERROR") && code)
    return {.kind = ReplyKind::error, .code = static_cast<std::uint8_t>(*code)};
  if (const auto code = code_after(7); begins("WARNING") && code)
    return {.kind = ReplyKind::warning, .code = static_cast<std::uint8_t>(*code)};
  return {.kind = ReplyKind::data};
}

const char* error_text(std::uint8_t code) noexcept {
  static constexpr std::array texts{
      "no error",
      "invalid command: not supported by its firmware",
      "command too long",
      "command too short",
      "the CRC of the command is wrong: check the line and its cable for noise",
      "time-out while the command was carried out",
      "cannot use these communication parameters: choose another baud",
      "wrong number of parameters",
      "no such port handle: check that the tool is plugged in",
      "invalid tracking priority",
      "invalid LED",
      "invalid LED state",
      "not allowed in the present mode: another program may be using the tracker",
      "no tool is assigned to the port handle",
      "the port handle is not initialised",
      "the port handle is not enabled",
      "the system is not initialised",
      "cannot stop tracking",
      "cannot start tracking",
      "cannot initialise the tool: check its definition file and its plug",
      "the characterisation of the sensor or field generator is not valid",
      "cannot initialise the system",
      "cannot start diagnostics",
      "cannot stop diagnostics",
      "cannot measure environmental infrared or magnetic interference",
      "cannot read the firmware version of a part",
      "internal error of the tracker: switch it off and on",
      "cannot initialise environmental infrared diagnostics",
      "cannot set the marker firing signature",
      "cannot find SROM devices",
      "cannot read the SROM of the tool",
      "cannot write the SROM of the tool",
  };
  return code < texts.size() ? texts[code] : "unknown error: see NDI's API guide";
}

const char* warning_text(std::uint8_t code) noexcept {
  static constexpr std::array texts{
      "no warning",
      "possible hardware fault",
      "the tool violates the rules of unique geometry",
      "the tool is not compatible with other loaded tools",
      "the tool is not compatible with other loaded tools and violates design rules",
      "the tool reports no marker wavelength: the default is used",
  };
  return code < texts.size() ? texts[code] : "unknown warning: see NDI's API guide";
}

}  // namespace godobject::ndi
