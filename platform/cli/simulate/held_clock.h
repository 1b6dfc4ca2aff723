// Clock of the simulated hardware: wall time, without the time for which the simulating program is held up.
// Hardware is never held up. A simulated drive that missed time with its program would find its deadline
// passed before it has read the frames that arrived meanwhile.
#pragma once

#include <algorithm>

#include "hal/base/nanoseconds.h"

namespace godobject {

class HeldClock {
 public:
  /// Longest lateness that the simulation makes up for; only the rest is lost. It is below the deadlines of
  /// drives, and long enough for wires to keep their speed on a busy machine.
  static constexpr Nanoseconds made_up_ns = 5'000'000;

  /// Returns the simulated time at `wall_ns`, the time since the start.
  /// due_ns: simulated time at which the program had to go on; it does so earlier if frames arrive.
  Nanoseconds advance(Nanoseconds wall_ns, Nanoseconds due_ns) noexcept {
    const Nanoseconds late_ns = wall_ns - held_ns_ - std::max(due_ns, now_ns_);
    held_ns_ += std::max<Nanoseconds>(0, late_ns - made_up_ns);
    now_ns_ = wall_ns - held_ns_;
    return now_ns_;
  }
  /// Returns the latest simulated time.
  Nanoseconds now() const noexcept { return now_ns_; }
  /// Returns the wall time, since the start, of a simulated time that is not over yet.
  Nanoseconds wall(Nanoseconds simulated_ns) const noexcept { return simulated_ns + held_ns_; }
  /// Returns the total time of all holds.
  Nanoseconds held() const noexcept { return held_ns_; }

 private:
  Nanoseconds now_ns_ = 0;
  Nanoseconds held_ns_ = 0;
};

}  // namespace godobject
