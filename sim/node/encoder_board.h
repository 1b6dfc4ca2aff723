// Simulated encoder board: the far end of its serial line. It sends frames by its own clock.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "hal/board/encoder_board.h"
#include "sim/bus/random.h"

namespace godobject {

/// Active faults, until reset.
struct SimBoardFaults {
  bool silent = false;
  double drop_probability = 0;     // per frame
  double corrupt_probability = 0;  // per frame: one bit is flipped
  double clock_drift = 0;          // rate error of its clock, 1e-6; positive: fast
};

class SimEncoderBoard {
 public:
  SimEncoderBoard(double rate_hz, std::size_t num_counts, std::uint64_t seed) noexcept
      : period_(1e9 / rate_hz), random_(seed) {
    frame_.num_counts = num_counts;
  }

  void set_count(std::size_t i, std::int32_t counts) noexcept { frame_.counts[i] = counts; }
  void set_status(std::uint16_t status) noexcept { frame_.status = status; }
  /// Power-cycles the board.
  void reboot() noexcept { started_ = false; }

  /// Returns the due frame; empty if none. out: at least max_encoder_wire bytes.
  std::span<const std::uint8_t> transmit(std::span<std::uint8_t> out, Nanoseconds now) noexcept;

  SimBoardFaults faults{};

 private:
  double period_;  // ns of its own clock
  EncoderFrame frame_;
  Nanoseconds last_ = 0;
  double clock_ns_ = 0, next_ns_ = 0;  // ns of its own clock
  bool started_ = false;
  SplitMix64 random_;
};

}  // namespace godobject
