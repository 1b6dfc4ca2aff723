// NDI Combined API of Polaris, Vega and Aurora: commands, and replies taken from a stream of bytes. A tracker speaks
// only when it is asked. Source: the recorded streams of the tests and NDI's API guide as public clients use it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace godobject::ndi {

/// What a serial port speaks after power-up and after a serial break: 9600 bit/s, 8N1.
inline constexpr std::uint32_t default_baud = 9600;

/// A command as it goes on the wire: NAME ':' parameters, CRC-16/ARC as four hexadecimal digits, CR.
struct Command {
  std::array<std::uint8_t, 160> data{};
  std::size_t size = 0;  // 0: name and parameters are too long

  std::span<const std::uint8_t> bytes() const noexcept { return {data.data(), size}; }
};
Command make_command(std::string_view name, std::string_view parameters) noexcept;

/// Parameters that begin with a port handle: ("PINIT", 0x0A) is PINIT:0A.
Command make_handle_command(std::string_view name, std::uint8_t handle, std::string_view more = {}) noexcept;

/// One block of a tool definition file: 64 bytes, the last ones zero where the file ends. `address` is a multiple of
/// block_size.
inline constexpr std::size_t block_size = 64;
Command make_write_command(std::uint8_t handle, std::size_t address,
                           std::span<const std::uint8_t> file) noexcept;

/// The digit of COMM for a bit rate; none for a rate that no tracker has.
std::optional<char> comm_digit(std::uint32_t baud) noexcept;

/// Takes replies out of the stream and checks their CRC: text up to CR, or a binary reply with a checked header.
class ReplyReceiver {
 public:
  static constexpr std::size_t capacity = 18 * 1024;  // bytes of one reply: TX with the poses of 254 handles

  enum class Event : std::uint8_t {
    more,
    text,      // content(): the characters before the CRC
    binary,    // content(): the body of a BX reply before its CRC
    bad_crc,   // a whole reply is lost
    too_long,  // more than `capacity` without an end: what there is is lost
  };

  Event push(std::uint8_t byte) noexcept;
  /// Forgets a reply that has begun: before a command, and after a silence.
  void reset() noexcept { size_ = 0; }
  /// Until the next byte.
  std::span<const std::uint8_t> content() const noexcept { return content_; }

 private:
  Event finish_text() noexcept;
  Event push_binary() noexcept;

  std::array<std::uint8_t, capacity> data_{};
  std::size_t size_ = 0;
  std::span<const std::uint8_t> content_;
};

/// The kinds of text replies.
enum class ReplyKind : std::uint8_t { okay, error, warning, reset, data };
struct TextReply {
  ReplyKind kind = ReplyKind::data;
  std::uint8_t code = 0;  // of an error or a warning
};
TextReply classify(std::span<const std::uint8_t> text) noexcept;

/// Meaning of the code of an ERROR reply, and of a WARNING reply.
const char* error_text(std::uint8_t code) noexcept;
const char* warning_text(std::uint8_t code) noexcept;

}  // namespace godobject::ndi
