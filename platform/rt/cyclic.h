// Loop with absolute deadlines on a monotonic clock: counts late cycles and skipped periods, and watches the
// consequences of missed deadlines.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>

#include "hal/can/frame.h"
#include "platform/rt/loop_calls.h"

namespace godobject {

/// Clock of the loop, never wall time: CLOCK_MONOTONIC, with the functions that Cyclic requires. Tests use
/// clocks of their own.
struct MonotonicClock {
  Nanoseconds now() const noexcept {
    const timespec t = loop::now(CLOCK_MONOTONIC);
    return Nanoseconds{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  }

  /// Returns at t or later; at once if t has passed. A signal does not shorten the wait.
  void sleep_until(Nanoseconds t) const noexcept {
    timespec until{};
    until.tv_sec = static_cast<std::time_t>(t / 1'000'000'000);
    until.tv_nsec = static_cast<long>(t % 1'000'000'000);
    while (loop::sleep_until(until) == EINTR) continue;
  }
};

/// Counts values in log-linear bins: exact up to 2 * steps_per_octave, then steps_per_octave equal bins per
/// octave. A bin's edge is at most 1/32 above any value in it.
/// Values below 0 count as 0; values of 2^40 and above (18 min in ns) count in the last bin. Adding is
/// real-time.
/// Histogram of durations with bins of fixed relative width: an hour of a loop in 9 kB.
class Histogram {
 public:
  static constexpr unsigned steps_log2 = 5;
  static constexpr std::uint64_t steps_per_octave = 1u << steps_log2;
  static constexpr unsigned max_bits = 40;
  static constexpr std::size_t num_bins = (max_bits - steps_log2 + 1) * steps_per_octave;

  void add(std::int64_t value) noexcept {
    value = std::max<std::int64_t>(value, 0);
    ++bins_[bin_of(static_cast<std::uint64_t>(value))];
    ++count_;
    max_ = std::max(max_, value);
  }

  std::uint64_t count() const noexcept { return count_; }
  std::int64_t max() const noexcept { return max_; }
  std::uint64_t in_bin(std::size_t bin) const noexcept { return bins_[bin]; }

  /// Returns the largest value of the bin.
  static constexpr std::int64_t upper_edge(std::size_t bin) noexcept {
    if (bin < 2 * steps_per_octave) return static_cast<std::int64_t>(bin);
    const std::size_t shift = bin / steps_per_octave - 1;
    const std::uint64_t step = steps_per_octave + bin % steps_per_octave;
    return static_cast<std::int64_t>(((step + 1) << shift) - 1);
  }

  /// Returns a bound that at least this share of the values does not exceed, within a bin's width; 0 if
  /// empty. share: 0 to 1.
  std::int64_t percentile(double share) const noexcept {
    const double rank = std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_));
    std::uint64_t seen = 0;
    for (std::size_t bin = 0; bin < num_bins; ++bin) {
      seen += bins_[bin];
      if (seen > 0 && static_cast<double>(seen) >= rank) return std::min(upper_edge(bin), max_);
    }
    return max_;
  }

 private:
  static constexpr std::size_t bin_of(std::uint64_t value) noexcept {
    if (value < 2 * steps_per_octave) return static_cast<std::size_t>(value);
    if (value >> max_bits != 0) return num_bins - 1;
    const auto shift = static_cast<unsigned>(std::bit_width(value)) - (steps_log2 + 1);
    return static_cast<std::size_t>(shift * steps_per_octave + (value >> shift));
  }

  std::array<std::uint64_t, num_bins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ = 0;
};

struct CyclicStatistics {
  Histogram wake_ns;   // from the planned to the actual start of a cycle
  Histogram cycle_ns;  // from the start of a cycle to its end, waits included
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
  void run(Work&& work) noexcept GODOBJECT_NONBLOCKING {
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
      statistics_.cycle_ns.add(end - start);
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
  static constexpr std::uint64_t longest_hold =
      20;  // hold that is a fault, in windows: a force that was away for 2 s does not return unasked

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
    if (!holds()) last_kept_ = period_;
  }
  void reset() noexcept { *this = DeadlineWatch(window_); }

  /// True after 5 or more misses within the last 100 ms.
  bool holds() const noexcept {
    const std::uint64_t oldest = last_[next_];
    return oldest > 0 && period_ - oldest < window_;
  }
  /// True after 20 misses in a row, or at the end of a hold of 2 s.
  bool lost() const noexcept {
    return in_a_row_ >= too_many || period_ - last_kept_ >= longest_hold * window_;
  }

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
  std::uint64_t last_kept_ = 1;  // last period without a hold
};

}  // namespace godobject
