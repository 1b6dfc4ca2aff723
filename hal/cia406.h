// Absolute encoders (CiA 406): the position message.
#pragma once

#include "hal/canopen.h"

namespace godobject::cia406 {

inline constexpr std::uint8_t position_size = 4;

/// TPDO1 {6004h:32}: position in counts, 0 .. modulus - 1.
constexpr CanFrame make_position(std::uint8_t node, std::uint32_t position_counts) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(1, node), .size = position_size};
  ByteWriter(frame.data).put(position_counts);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_position(const CanFrame& frame, std::uint8_t node,
                                                   std::uint32_t& position_counts) noexcept {
  const ParseResult result = canopen::check_message(frame, canopen::tpdo_cob_id(1, node), position_size);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(position_counts);
  return result;
}

}  // namespace godobject::cia406
