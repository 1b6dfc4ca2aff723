// Reports of a tracker's thread, read until a condition holds.
#pragma once

#include <functional>

#include "platform/linux/device_threads.h"
#include "platform/rt/cyclic.h"

namespace godobject::test {

/// Reads until the condition holds; returns false after 20 s.
inline bool read_until(TrackerThread& thread, TrackerReport& report, const std::function<bool()>& condition) {
  const MonotonicClock clock;
  const Nanoseconds end = clock.now() + 20'000'000'000;
  while (clock.now() < end) {
    static_cast<void>(thread.try_read(report, 0));
    if (condition()) return true;
    clock.sleep_until(clock.now() + 1'000'000);
  }
  return false;
}

}  // namespace godobject::test
