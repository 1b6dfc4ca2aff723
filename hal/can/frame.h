// CAN frame, classic or FD, common to all bus backends.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/nonblocking.h"
#include "hal/base/nanoseconds.h"

namespace godobject {

struct CanFrame {
  std::uint32_t id = 0;  // 11 bits, or 29 when extended
  bool extended = false;
  bool remote = false;  // classic only
  bool fd = false;
  bool bit_rate_switch = false;  // FD only
  std::uint8_t size = 0;         // bytes of data: 0..8 classic, 0..64 FD
  std::array<std::uint8_t, 64> data{};

  constexpr std::span<const std::uint8_t> bytes() const noexcept { return {data.data(), size}; }
};

/// True if a frame can be sent: identifier in range, size allowed by its format, flags compatible.
constexpr bool is_valid(const CanFrame& frame) noexcept {
  if (frame.id > (frame.extended ? 0x1FFF'FFFFu : 0x7FFu)) return false;
  if (!frame.fd) return frame.size <= 8 && !frame.bit_rate_switch;
  if (frame.remote) return false;
  switch (frame.size) {
    case 12:
    case 16:
    case 20:
    case 24:
    case 32:
    case 48:
    case 64: return true;
    default: return frame.size <= 8;
  }
}

struct ReceivedFrame {
  CanFrame frame;
  Nanoseconds t_ns = 0;  // end of the frame on the wire, in the clock of the bus
};

/// Callback for each frame completed on a wire, called once per frame, for every sender.
struct FrameObserver {
  void (*on_frame)(void* context, const ReceivedFrame& frame) GODOBJECT_NONBLOCKING = nullptr;
  void* context = nullptr;
};

}  // namespace godobject
