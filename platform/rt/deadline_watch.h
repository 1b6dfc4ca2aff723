// What missed deadlines lead to. Time is counted in periods.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace godobject {

/// A deadline is missed by a cycle that ends after its period, and by each period in which no cycle ran.
class DeadlineWatch {
 public:
  static constexpr std::size_t many = 5;  // in window_s: the pose is held, the force fades
  static constexpr double window_s = 0.1;
  static constexpr std::uint64_t too_many =
      20;  // in a row: a fault. So long does a drive's watchdog wait at 1 kHz

  explicit DeadlineWatch(double step_s)
      : window_(static_cast<std::uint64_t>(std::max(std::llround(window_s / step_s), 1LL))) {}

  /// Before each cycle: whether the one before was late, and how many periods have been left out since.
  void add(bool late, std::uint64_t skipped) noexcept {
    if (late) miss(period_);
    else in_a_row_ = 0;
    for (std::uint64_t left = std::min<std::uint64_t>(skipped, too_many); left > 0; --left)
      miss(period_ + skipped + 1 - left);
    period_ += skipped + 1;
  }
  void reset() noexcept { *this = DeadlineWatch(window_); }

  /// 5 or more within the last 100 ms.
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
  std::uint64_t period_ = 1;                // of the cycle that comes
  std::array<std::uint64_t, many> last_{};  // periods of the last misses; 0: none
  std::size_t next_ = 0;
  std::uint64_t in_a_row_ = 0;
};

}  // namespace godobject
