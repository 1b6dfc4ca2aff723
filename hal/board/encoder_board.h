// Encoder boards on a serial line: a microcontroller sends its counts, unrequested, at its own rate. One
// frame is COBS( u8 type, u8 sequence, u32 t_us, n x i32 counts, u16 status, u16 CRC-16/CCITT-FALSE of all
// preceding bytes ), 00; little-endian. docs/encoder-board has a sketch that sends it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/base/clock_map.h"
#include "hal/base/cobs.h"
#include "hal/base/codec.h"

namespace godobject {

inline constexpr std::uint8_t counts_frame_type = 0x01;
inline constexpr std::size_t max_board_counts = 12;

/// Bits of EncoderFrame::status. The other bits are board-specific.
namespace board_status {
inline constexpr std::uint16_t not_referenced = 0x0001;  // counts are relative to the position at power-on
inline constexpr std::uint16_t overrun = 0x0002;         // the board missed an edge or one of its own samples
}  // namespace board_status

struct EncoderFrame {
  std::uint8_t sequence = 0;  // frame counter, wraps
  std::uint32_t t_us = 0;     // board time at which the counts were sampled, us; wraps after 71 minutes
  std::array<std::int32_t, max_board_counts> counts{};
  std::size_t num_counts = 0;
  std::uint16_t status = 0;  // see board_status
};

inline constexpr std::size_t max_encoder_payload = 10 + 4 * max_board_counts;
inline constexpr std::size_t max_encoder_wire = cobs_size(max_encoder_payload);

/// Encodes a frame for the wire into `out` (max_encoder_wire bytes suffice). Returns an empty span if
/// num_counts is too large or `out` too small.
[[nodiscard]] std::span<const std::uint8_t> make_encoder_frame(const EncoderFrame& frame,
                                                               std::span<std::uint8_t> out) noexcept;

/// Parses a payload from CobsDecoder. Returns `bad_value` for a wrong CRC, `other_message` for another type.
[[nodiscard]] ParseResult parse_encoder_frame(std::span<const std::uint8_t> payload,
                                              EncoderFrame& out) noexcept;

struct BoardCounters {
  std::uint64_t frames = 0;
  std::uint64_t lost = 0;  // missing in the sequence
  std::uint64_t bad_crc = 0;
  std::uint64_t malformed = 0;  // cut off, too large, or of an unknown type
  std::uint64_t reboots = 0;    // restarts of the board's clock
};

/// Host side of a board: the newest frame and the host time of its sample. ClockMap maps the board's clock,
/// therefore t_ns() is free of the jitter of wire and adapter.
class EncoderBoard {
 public:
  /// Decodes any bytes. Returns true if a new frame is complete.
  bool receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept;

  const EncoderFrame& frame() const noexcept { return frame_; }
  Nanoseconds t_ns() const noexcept { return t_ns_; }
  const BoardCounters& counters() const noexcept { return counters_; }
  const ClockMap& clock() const noexcept { return clock_; }

 private:
  void take(const EncoderFrame& frame, Nanoseconds now) noexcept;

  CobsDecoder decoder_;
  EncoderFrame frame_;
  UnwrappedCount time_us_;
  ClockMap clock_;
  Nanoseconds t_ns_ = 0;
  Nanoseconds t_arrival_ = 0;  // arrival of the previous frame
  BoardCounters counters_;
};

}  // namespace godobject
