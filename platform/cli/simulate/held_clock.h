// Clock of the simulated hardware: wall time, but it stands still while the simulating program is held up.
// Hardware is never held up. A simulated drive that missed time with its program would find its deadline
// passed before it has read the frames that arrived meanwhile.
#pragma once

#include <algorithm>

#include "hal/base/nanoseconds.h"

namespace godobject {

class HeldClock {
 public:
  /// Wake-ups later than this are holds.
  static constexpr Nanoseconds tolerance_ns = 1'000'000;

  /// Returns the simulated time at `wall`, the time since the start.
  /// due: simulated time at which the program had to go on; it does so earlier if frames arrive.
  Nanoseconds advance(Nanoseconds wall, Nanoseconds due) noexcept {
    const Nanoseconds late_ns = wall - held_ns_ - std::max(due, now_ns_);
    if (late_ns > tolerance_ns) held_ns_ += late_ns;
    now_ns_ = wall - held_ns_;
    return now_ns_;
  }
  /// Returns the wall time, since the start, of a simulated time that is not over yet.
  Nanoseconds wall(Nanoseconds simulated) const noexcept { return simulated + held_ns_; }
  /// Returns the total time of all holds.
  Nanoseconds held() const noexcept { return held_ns_; }

 private:
  Nanoseconds now_ns_ = 0;
  Nanoseconds held_ns_ = 0;
};

}  // namespace godobject
