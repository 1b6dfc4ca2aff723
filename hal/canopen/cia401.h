// Digital inputs (CiA 401): buttons.
#pragma once

#include "hal/canopen/canopen.h"

namespace godobject::cia401 {

inline constexpr std::uint8_t inputs_size = 1;

/// TPDO1 {6000h:01:8}: eight digital inputs. Sent when an input changes, and by the event timer.
constexpr CanFrame make_inputs(std::uint8_t node, std::uint8_t inputs) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(1, node), .size = inputs_size};
  frame.data[0] = inputs;
  return frame;
}

/// Parses the first byte of inputs; up to 7 more may follow from nodes with more inputs.
[[nodiscard]] constexpr ParseResult parse_inputs(const CanFrame& frame, std::uint8_t node,
                                                 std::uint8_t& inputs) noexcept {
  if (!canopen::is_canopen(frame) || frame.id != canopen::tpdo_cob_id(1, node))
    return ParseResult::other_message;
  if (frame.size < inputs_size) return ParseResult::too_short;
  inputs = frame.data[0];
  return ParseResult::ok;
}

}  // namespace godobject::cia401
