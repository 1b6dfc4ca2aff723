// Loop with absolute deadlines; counts late cycles and skipped periods.
#pragma once

#include "platform/rt/histogram.h"

#include "hal/can/frame.h"

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

}  // namespace godobject
