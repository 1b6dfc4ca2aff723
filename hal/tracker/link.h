// The loop's end of a tracker, whatever thread or simulation is behind it.
#pragma once

#include "hal/tracker/tracker.h"

namespace godobject {

class TrackerLink {
 public:
  virtual ~TrackerLink() = default;

  /// Every cycle, before try_read(). motion_time: s, where a simulated hand is by then.
  virtual void begin_cycle(Nanoseconds now, double motion_time) noexcept {
    static_cast<void>(now);
    static_cast<void>(motion_time);
  }
  /// The newest report; false when there is none since the last one read. Never waits, locks or allocates.
  [[nodiscard]] virtual bool try_read(TrackerReport& out, Nanoseconds now) noexcept = 0;
  virtual const TrackerParams& params() const noexcept = 0;
};

}  // namespace godobject
