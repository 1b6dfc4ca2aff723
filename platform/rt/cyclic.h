// The loop that keeps a period: absolute deadlines, what was late and what was left out.
#pragma once

#include "platform/rt/histogram.h"

#include "hal/can/frame.h"

namespace godobject {

struct CyclicStatistics {
  Histogram wake_ns;     // from the time a cycle was to start to its start
  Histogram compute_ns;  // from the start of a cycle to its end
  std::uint64_t cycles = 0;
  std::uint64_t late = 0;     // cycles that ended after their period
  std::uint64_t skipped = 0;  // whole periods in which no cycle ran

  std::uint64_t missed() const noexcept { return late + skipped; }
};

/// How a cycle begins. Stands for the latency alone where no more is wanted.
struct Wake {
  Nanoseconds latency = 0;    // from the time it was to start to its start
  std::uint64_t skipped = 0;  // periods left out before it
  bool late_before = false;   // the cycle before ended after its period

  operator Nanoseconds() const noexcept { return latency; }
};

/// Clock: Nanoseconds now(), void sleep_until(Nanoseconds).
template <class Clock>
class Cyclic {
 public:
  Cyclic(Clock& clock, Nanoseconds period) noexcept : clock_(clock), period_(period) {}

  /// Calls work(Wake) once a period, for the first time one period from now, until it
  /// returns false. Late by less than a period: runs at once, and the phase stays. Whole periods that have
  /// passed are left out and counted: the work's own step is never stretched, nor are cycles crowded.
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
