// How many bits a CAN frame takes on the wire, and how long that lasts.
// Every length includes the three bits of intermission that follow a frame. Frames must be valid (is_valid).
#pragma once

#include "hal/can/frame.h"

namespace godobject {

/// Bit rates in bit/s. The data rate is used by FD frames with bit-rate switch only.
struct BitRates {
  double nominal = 1e6;
  double data = 1e6;
};

/// Bits of one frame by the rate they travel at.
struct FrameBits {
  int nominal_rate = 0;
  int data_rate = 0;

  int total() const noexcept { return nominal_rate + data_rate; }
};

inline constexpr int intermission_bits = 3;
inline constexpr int end_of_frame_bits = 7;
inline constexpr int acknowledge_delimiter_bits = 1;
inline constexpr int error_flag_bits = 6;
inline constexpr int error_delimiter_bits = 8;
inline constexpr int suspend_transmission_bits = 8;  // an error-passive sender's pause before its next frame

/// Length without any stuff bit: the least a frame of this format and size can take (not for FD, where the
/// fixed stuff bits are counted and the dynamic ones are not).
FrameBits nominal_bits(const CanFrame& frame) noexcept;

/// Upper bound over all identifiers and data of this format and size.
/// Classic: one stuff bit for the first five bits and one for every four after them.
FrameBits worst_bits(const CanFrame& frame) noexcept;

/// Length of this very frame, its CRC and stuff bits computed (classic).
/// FD frames are given their upper bound worst_bits: their dynamic stuffing is not computed.
FrameBits exact_bits(const CanFrame& frame) noexcept;

/// Time of so many bits, rounded to the nanosecond.
Nanoseconds duration_ns(const FrameBits& bits, const BitRates& rates) noexcept;

/// Time of so many bits at the nominal rate, rounded to the nanosecond.
Nanoseconds duration_ns(int nominal_rate_bits, const BitRates& rates) noexcept;

}  // namespace godobject
