// Converts time stamps of a free-running clock to the clock of their reader.
#pragma once

#include <algorithm>

#include "hal/base/nanoseconds.h"

namespace godobject {

/// Offset between a CAN controller's crystal and the host clock, estimated from the least delayed frame. The
/// estimate may rise by the largest drift between both clocks.
class StampClock {
 public:
  static constexpr Nanoseconds drift_divisor = 5000;        // 200 ppm between the two crystals
  static constexpr Nanoseconds step_limit = 1'000'000'000;  // larger offset change: one of the clocks was set

  /// Returns the local time of `stamp`, at most `arrival`. stamp: time stamp of the frame by the foreign
  /// clock, ns. arrival: local time of its arrival, ns.
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
