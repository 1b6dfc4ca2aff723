// The kernel's receive time stamps (SO_TIMESTAMPING) on CLOCK_MONOTONIC.
#pragma once

#include <sys/socket.h>

#include "hal/base/stamp_clock.h"

namespace godobject {

/// Enables the stamps. Returns false with errno on failure.
bool enable_receive_stamps(int socket) noexcept;

/// Converts receive stamps. The kernel stamps a frame by the wall clock when the driver delivers it.
/// It adds the controller's own stamp if there is one (raw hardware, on a clock of its own).
/// - Wall clock: both clocks are read together with the frame, and the frame's age by the wall clock is
/// subtracted from CLOCK_MONOTONIC. If the wall clock is set between arrival and reading, the result is the
/// time of reading.
/// - Controller: StampClock, against the time of arrival found as above.
class ReceiveStamp {
 public:
  /// Returns the time of arrival of a message read by recvmsg; never before that of the previous message.
  /// Without a stamp it is the time of reading.
  Nanoseconds of(const msghdr& message) noexcept;

 private:
  StampClock controller_;
  Nanoseconds last_ = 0;
};

}  // namespace godobject
