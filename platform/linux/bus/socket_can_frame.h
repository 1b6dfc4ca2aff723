// CAN frames in the layout of Linux's raw sockets (<linux/can.h>).
#pragma once

#include <linux/can.h>

#include <algorithm>
#include <cstddef>
#include <optional>

#include "hal/can/frame.h"

namespace godobject {

/// A classic frame is the beginning of this struct: same layout, fewer bytes.
using KernelFrame = canfd_frame;

/// Returns the number of bytes of `out` for the kernel: CAN_MTU or CANFD_MTU. `frame` must be valid.
inline std::size_t to_kernel(const CanFrame& frame, KernelFrame& out) noexcept {
  out = {};
  out.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0u) | (frame.remote ? CAN_RTR_FLAG : 0u);
  out.len = frame.size;
  if (frame.bit_rate_switch) out.flags = CANFD_BRS;
  std::copy_n(frame.data.begin(), frame.size, out.data);
  return frame.fd ? CANFD_MTU : CAN_MTU;
}

/// Returns none if `size` is neither CAN_MTU nor CANFD_MTU, or the frame's length exceeds it.
inline std::optional<CanFrame> from_kernel(const KernelFrame& in, std::size_t size) noexcept {
  if (size != CAN_MTU && size != CANFD_MTU) return std::nullopt;
  CanFrame frame;
  frame.fd = size == CANFD_MTU;
  if (in.len > (frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return std::nullopt;
  frame.extended = (in.can_id & CAN_EFF_FLAG) != 0;
  frame.id = in.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.remote = !frame.fd && (in.can_id & CAN_RTR_FLAG) != 0;
  frame.bit_rate_switch = frame.fd && (in.flags & CANFD_BRS) != 0;
  frame.size = in.len;
  std::copy_n(in.data, in.len, frame.data.begin());
  return frame;
}

}  // namespace godobject
