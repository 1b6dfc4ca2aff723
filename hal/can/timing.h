// Length of a CAN frame on the wire, in bits and in time. Each length includes the three bits of intermission
// after the frame. Frames must be valid (is_valid).
#pragma once

#include "hal/can/frame.h"

namespace godobject {

/// Bit rates, bit/s. The data rate applies to FD frames with bit-rate switch only.
struct BitRates {
  double nominal = 1e6;
  double data = 1e6;
};

/// Bits of a frame, by the bit rate at which they are sent.
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
inline constexpr int suspend_transmission_bits = 8;  // pause of an error-passive sender before its next frame

/// Length without stuff bits: the minimum for this format and size. FD frames include their fixed stuff bits,
/// not the dynamic ones.
FrameBits nominal_bits(const CanFrame& frame) noexcept;

/// Upper bound over all identifiers and data of this format and size. Classic: one stuff bit for the first
/// five bits and one for each four after them.
FrameBits worst_bits(const CanFrame& frame) noexcept;

/// Length of this frame, with its CRC and stuff bits computed (classic). FD frames return worst_bits, because
/// their dynamic stuffing is not computed.
FrameBits exact_bits(const CanFrame& frame) noexcept;

/// Duration of these bits, rounded to ns.
Nanoseconds duration_ns(const FrameBits& bits, const BitRates& rates) noexcept;

/// Duration of these bits at the nominal rate, rounded to ns.
Nanoseconds duration_ns(int nominal_rate_bits, const BitRates& rates) noexcept;

}  // namespace godobject
