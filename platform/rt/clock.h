// Clock of the loop: monotonic, in nanoseconds, never wall time.
#pragma once

#include <cerrno>
#include <ctime>

#include "hal/can/frame.h"

namespace godobject {

/// CLOCK_MONOTONIC, with the functions that Cyclic requires; tests use clocks of their own.
struct MonotonicClock {
  Nanoseconds now() const noexcept {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return Nanoseconds{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  }

  /// Returns at t or later; at once if t has passed. A signal does not shorten the wait.
  void sleep_until(Nanoseconds t) const noexcept {
    timespec until{};
    until.tv_sec = static_cast<std::time_t>(t / 1'000'000'000);
    until.tv_nsec = static_cast<long>(t % 1'000'000'000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) continue;
  }
};

}  // namespace godobject
