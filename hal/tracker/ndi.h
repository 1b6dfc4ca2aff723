// NDI Combined API of Polaris, Vega and Aurora: commands, and replies from a byte stream. A tracker only
// replies to commands. Source: the recorded streams of the tests, and NDI's API guide as used by public
// clients.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace godobject::ndi {

/// Bit rate of a serial port after power-up and after a serial break: 9600 bit/s, 8N1.
inline constexpr std::uint32_t default_baud = 9600;

/// A command on the wire: NAME ':' parameters, CRC-16/ARC as four hexadecimal digits, CR.
struct Command {
  std::array<std::uint8_t, 160> data{};
  std::size_t size = 0;  // 0: name and parameters are too long

  std::span<const std::uint8_t> bytes() const noexcept { return {data.data(), size}; }
};
Command make_command(std::string_view name, std::string_view parameters) noexcept;

/// Makes a command whose parameters begin with a port handle: ("PINIT", 0x0A) is PINIT:0A.
Command make_handle_command(std::string_view name, std::uint8_t handle, std::string_view more = {}) noexcept;

/// Makes the write command of one block of a tool definition file: 64 bytes, padded with zeros at the end of
/// the file. address: multiple of block_size.
inline constexpr std::size_t block_size = 64;
Command make_write_command(std::uint8_t handle, std::size_t address,
                           std::span<const std::uint8_t> file) noexcept;

/// Returns the COMM digit of a bit rate; nullopt for an unsupported rate.
std::optional<char> comm_digit(std::uint32_t baud) noexcept;

/// Extracts replies from the stream and checks their CRC: text up to CR, or binary with a checked header.
class ReplyReceiver {
 public:
  // largest reply, bytes: TX with the poses of 254 handles
  static constexpr std::size_t capacity = 18 * 1024;

  enum class Event : std::uint8_t {
    more,
    text,      // content(): characters before the CRC
    binary,    // content(): body of a BX or BX2 reply before its CRC
    bad_crc,   // a reply with a wrong CRC: it is lost
    too_long,  // more than `capacity` bytes without an end: they are lost
  };

  Event push(std::uint8_t byte) noexcept;
  /// Drops a partial reply; call it before a command and after a silence.
  void reset() noexcept { size_ = 0; }
  /// Valid until the next byte.
  std::span<const std::uint8_t> content() const noexcept { return content_; }

 private:
  Event finish_text() noexcept;
  Event push_binary() noexcept;

  std::array<std::uint8_t, capacity> data_{};
  std::size_t size_ = 0;
  std::span<const std::uint8_t> content_;
};

/// Kinds of text replies.
enum class ReplyKind : std::uint8_t { okay, error, warning, reset, data };
struct TextReply {
  ReplyKind kind = ReplyKind::data;
  std::uint8_t code = 0;  // code of an error or a warning
};
TextReply classify(std::span<const std::uint8_t> text) noexcept;

/// Returns the meaning of the code of an ERROR reply, or of a WARNING reply.
const char* error_text(std::uint8_t code) noexcept;
const char* warning_text(std::uint8_t code) noexcept;

}  // namespace godobject::ndi
