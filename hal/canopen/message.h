// Messages of exactly eight bytes, for requests and answers of SDO (CiA 301) and LSS (CiA 305).
#pragma once

#include <algorithm>
#include <array>

#include "hal/canopen/canopen.h"

namespace godobject::canopen {

using Message = std::array<std::uint8_t, 8>;

constexpr CanFrame make_frame(std::uint32_t cob_id, const Message& message) noexcept {
  CanFrame frame{.id = cob_id, .size = 8};
  std::ranges::copy(message, frame.data.begin());
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_frame(const CanFrame& frame, std::uint32_t cob_id,
                                                Message& out) noexcept {
  const ParseResult result = check_message(frame, cob_id, 8);
  if (result == ParseResult::ok) std::copy_n(frame.data.begin(), out.size(), out.begin());
  return result;
}

}  // namespace godobject::canopen
