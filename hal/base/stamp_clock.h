// A free-running clock's time stamps, put on the clock of the one who reads them.
#pragma once

#include <algorithm>

#include "hal/can/frame.h"

namespace godobject {

/// A CAN controller stamps frames by its own crystal. How far its clock is off ours follows from the frame
/// that was least delayed on its way; drift lets that estimate rise again.
class StampClock {
 public:
  static constexpr Nanoseconds drift_divisor = 5000;        // 200 ppm between the two crystals
  static constexpr Nanoseconds step_limit = 1'000'000'000;  // beyond: one of the clocks was set anew

  /// `stamp`: the frame's, by the foreign clock; `arrival`: when our side had it, by our clock. Returns the
  /// time of `stamp` by our clock: at most `arrival`.
  Nanoseconds to_local(Nanoseconds stamp, Nanoseconds arrival) noexcept {
    const Nanoseconds difference = arrival - stamp;
    const Nanoseconds elapsed = std::max<Nanoseconds>(stamp - last_stamp_, 0);
    const Nanoseconds risen = offset_ + elapsed / drift_divisor;
    const bool stepped = difference - offset_ > step_limit || offset_ - difference > step_limit;
    offset_ = !known_ || stepped ? difference : std::min(difference, risen);
    known_ = true;
    last_stamp_ = stamp;
    return stamp + offset_;
  }

 private:
  bool known_ = false;
  Nanoseconds offset_ = 0;
  Nanoseconds last_stamp_ = 0;
};

}  // namespace godobject
