// SLCAN, the ASCII protocol of Lawicel's CAN232 and CANUSB and of their many clones. Lines end with CR, or
// with BEL if a command was refused. Host to adapter:
//   S0..S8                    bit rate, see bit_rates; only while the channel is closed
//   O, L, C                   open, open for listening only, close the channel
//   tIIILDD..                 send: three digits of identifier, size, data (hexadecimal)
//   TIIIIIIIILDD..            as t, with eight digits of identifier (29 bits)
//   rIIIL, RIIIIIIIIL         as t and T, remote frames
//   F, V, N, Z0, Z1           status flags, version, serial number, time stamps off and on
//
// Adapter to host: received frames in the same form, with four digits of milliseconds at the end after Z1.
// Other lines are z or Z for an accepted frame, and F with two digits. Linux's slcan driver also accepts
// sSRRRTTT and eNXX.. from the adapter: the controller's state with its receive and transmit error counters,
// and N error letters. Adapters for CAN FD send FD frames as d, D, b and B, with a DLC of one digit: they are
// recognised, not decoded. Adapters differ: stock CANables answer to V alone, some acknowledge with LF, UCCB
// accepts one command per write.
//
// Limits: no CAN FD; no controller state beyond the flags of F, thus no bus-off and no restart (except in the
// dialect of Linux's driver). Time stamps resolve 1 ms; hardware stamps cannot be distinguished from host
// stamps. Back-pressure is BEL only. A frame of 8 bytes has 22 characters: 1.9 ms on a line of 115 200 baud,
// 0.24 ms at 921 600. Suitable for encoders and tests, not for motors at 1 kHz.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/base/codec.h"
#include "hal/can/error.h"
#include "hal/can/frame.h"

namespace godobject::slcan {

/// Longest line including CR: an extended frame of 8 bytes with a time stamp.
inline constexpr std::size_t max_line = 1 + 8 + 1 + 16 + 4 + 1;

/// Bit rates of S0 to S8, bit/s.
inline constexpr std::array bit_rates{10e3, 20e3, 50e3, 100e3, 125e3, 250e3, 500e3, 800e3, 1e6};

inline constexpr std::string_view open_command = "O\r", listen_command = "L\r", close_command = "C\r",
                                  flags_command = "F\r", version_command = "V\r",
                                  serial_number_command = "N\r", timestamps_on_command = "Z1\r",
                                  timestamps_off_command = "Z0\r";

inline constexpr std::string_view ok_reply = "\r", refused_reply = "\a", taken_reply = "z\r",
                                  taken_extended_reply = "Z\r";

/// Returns the command for a bit rate, "S8\r" for 1e6; empty if no command exists for it.
std::string_view bit_rate_command(double bit_rate) noexcept;

/// Writes the line of a frame, including CR, and returns its length; max_line characters suffice. Returns 0
/// if `out` is too small or the protocol cannot carry the frame (CAN FD, or not is_valid).
[[nodiscard]] std::size_t format_frame(const CanFrame& frame, std::span<char> out,
                                       std::optional<std::uint16_t> timestamp_ms = std::nullopt) noexcept;

/// Status flags of command F (CANUSB manual). The adapter clears them when they are read.
namespace status {
inline constexpr std::uint8_t receive_queue_full = 1u << 0, transmit_queue_full = 1u << 1,
                              error_warning = 1u << 2, data_overrun = 1u << 3, error_passive = 1u << 5,
                              arbitration_lost = 1u << 6, bus_error = 1u << 7;
}

enum class ReplyKind : std::uint8_t {
  ok,            // CR alone: the command was executed
  refused,       // BEL
  taken,         // z or Z: the adapter will send our frame
  frame,         // received on the bus
  flags,         // F
  identity,      // V or N: version or serial number, as text
  error_report,  // s or e
  fd_frame,      // d, D, b or B: a CAN FD frame, which is not decoded
};

struct Reply {
  ReplyKind kind = ReplyKind::ok;
  CanFrame frame{};
  std::optional<std::uint16_t> timestamp_ms{};  // 0..59999, then from 0 again
  std::uint8_t flags = 0;
  CanErrorReport report{};
};

/// Parses a line of an adapter, without its CR; "\a" for BEL.
[[nodiscard]] ParseResult parse_reply(std::string_view line, Reply& out) noexcept;

enum class RequestKind : std::uint8_t {
  set_bit_rate,
  open,
  listen,
  close,
  send,
  flags,
  version,
  serial_number,
  timestamps,
};

struct Request {
  RequestKind kind = RequestKind::close;
  CanFrame frame{};
  std::uint8_t value = 0;  // index into bit_rates; 0 or 1 of timestamps
};

/// Parses a line of a host, without its CR. Returns other_message for a command outside the list above.
[[nodiscard]] ParseResult parse_request(std::string_view line, Request& out) noexcept;

/// Splits the byte stream into lines, which end with CR, LF, both of them, or BEL. Drops and counts lines
/// that are too long or cut off by a BEL. Resynchronises at the next line end.
class LineReader {
 public:
  /// Adds one byte. Returns true if line() is complete, valid until the next call.
  [[nodiscard]] bool put(std::uint8_t byte) noexcept;
  /// Returns the line without its end; "\a" if the line ended with BEL.
  std::string_view line() const noexcept { return {text_.data(), size_}; }
  std::uint64_t num_overlong() const noexcept { return num_overlong_; }
  /// Returns the number of lines cut off by a BEL.
  std::uint64_t num_cut() const noexcept { return num_cut_; }
  /// Returns the number of overlong lines that are CAN FD frames; num_overlong() excludes them.
  std::uint64_t num_fd() const noexcept { return num_fd_; }
  /// Returns the first max_line characters of the last overlong line.
  std::string_view overlong_begin() const noexcept {
    return num_overlong_ > 0 ? std::string_view(overlong_begin_.data(), overlong_begin_.size())
                             : std::string_view();
  }

 private:
  std::array<char, max_line> text_{};
  std::size_t size_ = 0;
  bool complete_ = false;
  bool overlong_ = false;
  // CR or LF that ended the last line; the other one right after it belongs to the same end
  char end_ = '\0';
  std::array<char, max_line> overlong_begin_{};
  std::uint64_t num_overlong_ = 0, num_cut_ = 0, num_fd_ = 0;
};

}  // namespace godobject::slcan
