// Loop with absolute deadlines: counts late cycles and skipped periods, and watches the consequences of
// missed deadlines.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "hal/can/frame.h"
#include "platform/rt/histogram.h"

namespace godobject {

struct CyclicStatistics {
  Histogram wake_ns;     // from the planned to the actual start of a cycle
  Histogram compute_ns;  // from the start of a cycle to its end
  std::uint64_t cycles = 0;
  std::uint64_t late = 0;     // cycles that ended after their period
  std::uint64_t skipped = 0;  // whole periods in which no cycle ran

  std::uint64_t missed() const noexcept { return late + skipped; }
};

/// Start of a cycle. Converts to the latency alone.
struct Wake {
  Nanoseconds latency = 0;    // from the planned to the actual start
  std::uint64_t skipped = 0;  // periods left out before this cycle
  bool late_before = false;   // true if the previous cycle ended after its period

  operator Nanoseconds() const noexcept { return latency; }
};

/// Clock: Nanoseconds now(), void sleep_until(Nanoseconds).
template <class Clock>
class Cyclic {
 public:
  Cyclic(Clock& clock, Nanoseconds period) noexcept : clock_(clock), period_(period) {}

  /// Calls work(Wake) once a period until it returns false; first one period from now.
  /// A cycle that is late by less than a period runs at once and keeps the phase. Whole periods that have
  /// passed are skipped and counted: cycles are neither stretched nor crowded.
  template <class Work>
  void run(Work&& work) noexcept {
    Nanoseconds release = clock_.now() + period_;
    bool late = false;
    for (bool more = true; more; release += period_) {
      clock_.sleep_until(release);
      const Nanoseconds start = clock_.now();
      const Nanoseconds latency = start - release;
      const Nanoseconds skipped = latency / period_;
      statistics_.skipped += static_cast<std::uint64_t>(skipped);
      release += skipped * period_;

      more = work(Wake{latency, static_cast<std::uint64_t>(skipped), late});

      const Nanoseconds end = clock_.now();
      statistics_.wake_ns.add(latency);
      statistics_.compute_ns.add(end - start);
      ++statistics_.cycles;
      late = end > release + period_;
      if (late) ++statistics_.late;
    }
  }

  const CyclicStatistics& statistics() const noexcept { return statistics_; }

 private:
  Clock& clock_;
  Nanoseconds period_;
  CyclicStatistics statistics_;
};

/// Counts missed deadlines: each cycle that ends after its period, and each period without a cycle. Time is
/// counted in periods.
class DeadlineWatch {
 public:
  static constexpr std::size_t many = 5;  // misses within window_s after which the pose is held and the force
                                          // fades
  static constexpr double window_s = 0.1;
  static constexpr std::uint64_t too_many =
      20;  // misses in a row that are a fault; equals the timeout of a drive's watchdog at 1 kHz

  explicit DeadlineWatch(double step_s)
      : window_(static_cast<std::uint64_t>(std::max(std::llround(window_s / step_s), 1LL))) {}

  /// Updates before each cycle. late: true if the previous cycle was late. skipped: periods left out since
  /// then.
  void add(bool late, std::uint64_t skipped) noexcept {
    if (late) miss(period_);
    else in_a_row_ = 0;
    for (std::uint64_t left = std::min<std::uint64_t>(skipped, too_many); left > 0; --left)
      miss(period_ + skipped + 1 - left);
    period_ += skipped + 1;
  }
  void reset() noexcept { *this = DeadlineWatch(window_); }

  /// True after 5 or more misses within the last 100 ms.
  bool holds() const noexcept {
    const std::uint64_t oldest = last_[next_];
    return oldest > 0 && period_ - oldest < window_;
  }
  bool lost() const noexcept { return in_a_row_ >= too_many; }

 private:
  explicit DeadlineWatch(std::uint64_t window) noexcept : window_(window) {}

  void miss(std::uint64_t period) noexcept {
    last_[next_] = period;
    next_ = (next_ + 1) % many;
    ++in_a_row_;
  }

  std::uint64_t window_;                    // periods
  std::uint64_t period_ = 1;                // number of the coming period
  std::array<std::uint64_t, many> last_{};  // periods of the last misses; 0 if none
  std::size_t next_ = 0;
  std::uint64_t in_a_row_ = 0;
};

}  // namespace godobject
