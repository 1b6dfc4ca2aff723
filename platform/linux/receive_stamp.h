// The kernel's receive time stamps (SO_TIMESTAMPING) on CLOCK_MONOTONIC.
#pragma once

#include <sys/socket.h>

#include "hal/base/stamp_clock.h"

namespace godobject {

/// Asks for the stamps; false: errno tells why.
bool enable_receive_stamps(int socket) noexcept;

/// The kernel stamps a frame by the wall clock when it takes it from the driver, and hands on the controller's own
/// stamp where the controller makes one (raw hardware: a clock of its own).
/// - Wall clock: both clocks are read when the frame is, and the frame's age by the wall clock is taken off
///   CLOCK_MONOTONIC. Nobody sees the wall clock; setting it between arrival and read gives the time of the read.
/// - Controller: StampClock, against the time of arrival found as above.
class ReceiveStamp {
 public:
  /// When the message that recvmsg has just filled in arrived; never before the message before it. A message without
  /// a stamp gets the time of the read.
  Nanoseconds of(const msghdr& message) noexcept;

 private:
  StampClock controller_;
  Nanoseconds last_ = 0;
};

}  // namespace godobject
