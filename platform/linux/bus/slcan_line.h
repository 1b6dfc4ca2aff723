// A serial port with SLCAN lines, shared by both ends of the protocol.
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

  /// Queues `text` and writes as much as the port accepts. Returns false and queues nothing if there is no
  /// space for all of it.
  [[nodiscard]] bool put(std::string_view text) noexcept;
  /// Writes queued lines, as many as the port accepts, one write per line. Some adapters read one command of
  /// a USB packet and drop the others.
  void flush() noexcept;
  /// Returns the line of a frame; empty if the protocol cannot carry it.
  static std::string text_of(const CanFrame& frame);
  /// Returns the rest of the line that the last write cut off.
  const LineRest& rest() const noexcept { return rest_; }
  /// Returns the next complete line, valid until the next call. False if there is none yet, or if the limit
  /// on reads per call is reached.
  [[nodiscard]] bool next(std::string_view& line) noexcept;
  /// Time of reading the last line's final bytes: CLOCK_MONOTONIC.
  Nanoseconds read_at() const noexcept { return read_at_; }
  /// Discards queued output.
  void discard_output() noexcept { out_size_ = 0; }
  /// Discards received bytes: the next byte begins a line.
  void discard_input() noexcept;
  /// Discards queued output and received bytes.
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
