// Consequences of missed deadlines. Time is counted in periods.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace godobject {

/// Counts missed deadlines: each cycle that ends after its period, and each period without a cycle.
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
