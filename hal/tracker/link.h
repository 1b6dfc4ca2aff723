// Interface of a tracker to the loop, independent of its thread or simulation.
#pragma once

#include "core/nonblocking.h"
#include "hal/tracker/tracker.h"

namespace godobject {

class TrackerLink {
 public:
  virtual ~TrackerLink() = default;

  /// Call it every cycle before try_read(). motion_time: time of the simulated hand's motion, s.
  virtual void begin_cycle(Nanoseconds now, double motion_time) noexcept GODOBJECT_NONBLOCKING {
    static_cast<void>(now);
    static_cast<void>(motion_time);
  }
  /// Reads the newest report; false if there is none since the last one read. Never waits, locks or
  /// allocates.
  [[nodiscard]] virtual bool try_read(TrackerReport& out, Nanoseconds now) noexcept GODOBJECT_NONBLOCKING = 0;
  virtual const TrackerParams& params() const noexcept GODOBJECT_NONBLOCKING = 0;
};

}  // namespace godobject
