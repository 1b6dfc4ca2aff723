// A serial port with lines of SLCAN on it: what both ends of the protocol share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/can/slcan.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/last_resort.h"

namespace godobject {

/// Neither put() nor next() waits or allocates.
class SlcanLine {
 public:
  SerialPort& port() noexcept { return port_; }
  const SerialPort& port() const noexcept { return port_; }

  /// Queues `text` and writes what the port takes. False: there is no room for all of it; none of it is
  /// queued.
  [[nodiscard]] bool put(std::string_view text) noexcept;
  /// Writes what is queued, as much as the port takes, each line in a write of its own: some adapters take
  /// one command of a USB packet and drop the others.
  void flush() noexcept;
  /// Returns the line of a frame; empty: the protocol cannot carry it.
  static std::string text_of(const CanFrame& frame);
  /// Returns the rest of the line that the last write has cut off.
  const LineRest& rest() const noexcept { return rest_; }
  /// The next complete line, valid until the next call. False: there is none now, or the call has read so
  /// much without finding one that the rest is left to the next.
  [[nodiscard]] bool next(std::string_view& line) noexcept;
  /// When the bytes that ended the last line were read: CLOCK_MONOTONIC.
  Nanoseconds read_at() const noexcept { return read_at_; }
  /// Forgets what is queued.
  void discard_output() noexcept { out_size_ = 0; }
  /// Forgets what was read: the next byte begins a line.
  void discard_input() noexcept;
  /// Forgets what is queued and what was read.
  void clear() noexcept;

  /// Counts and beginnings of lines that were dropped.
  const slcan::LineReader& reader() const noexcept { return reader_; }

 private:
  SerialPort port_{};
  slcan::LineReader reader_{};
  std::array<std::uint8_t, 64 * slcan::max_line> out_{};  // some milliseconds of a busy bus
  std::size_t out_size_ = 0;
  LineRest rest_{};
  std::array<std::uint8_t, 512> in_{};
  std::size_t in_begin_ = 0, in_end_ = 0;
  Nanoseconds read_at_ = 0;
};

}  // namespace godobject
