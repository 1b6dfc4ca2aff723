// Detects a force that oscillates between its bounds, as an unstable feedback loop does.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace godobject {

/// Watches one component of a displayed wrench, or one motor's command.
///
/// Detects an oscillation: at least 25 reversals within 0.5 s, each after a travel of at least half of the
/// bounds' maximum per period. In addition the value must be at a bound (of size or rate) in at least 80 % of
/// the cycles. 25 reversals correspond to 25 Hz: faster than a hand (10 Hz). Values below their bounds, as of
/// a texture, never count. Counts are kept in tenths of the window, which delays detection by at most 0.05 s.
class SwingWatch {
 public:
  static constexpr double window_s = 0.5;
  static constexpr std::uint32_t least_turns = 25;
  static constexpr double least_bounded_share = 0.8;

  /// bound: largest absolute value. rate: largest change per second. period_s: of update(), s.
  SwingWatch(double bound, double rate, double period_s) noexcept
      : least_way_(0.5 * std::min(bound, rate * period_s)),
        cycles_per_part_(
            static_cast<std::uint32_t>(std::max(1L, std::lround(window_s / num_parts / period_s)))) {}

  void reset() noexcept { *this = SwingWatch(least_way_, cycles_per_part_); }

  /// Adds one cycle. bounded: the value was limited. Returns true if it oscillates.
  bool update(double value, bool bounded) noexcept {
    Part& part = parts_[newest_];
    ++part.cycles;
    part.bounded += bounded ? 1 : 0;
    part.turns += turned(value) ? 1 : 0;
    if (part.cycles < cycles_per_part_) return false;
    const bool swings = all_parts_swing();
    newest_ = (newest_ + 1) % num_parts;
    parts_[newest_] = {};
    return swings;
  }

 private:
  static constexpr std::size_t num_parts = 10;
  struct Part {
    std::uint32_t cycles = 0, bounded = 0, turns = 0;
  };

  SwingWatch(double least_way, std::uint32_t cycles_per_part) noexcept
      : least_way_(least_way), cycles_per_part_(cycles_per_part) {}

  /// True if the value reverses from the last extreme by more than least_way_.
  bool turned(double value) noexcept {
    const bool further = rising_ ? value >= extreme_ : value <= extreme_;
    if (further) extreme_ = value;
    if (further || std::abs(value - extreme_) < least_way_) return false;
    rising_ = !rising_;
    extreme_ = value;
    return true;
  }

  bool all_parts_swing() const noexcept {
    Part sum;
    for (const Part& part : parts_) {
      sum.cycles += part.cycles;
      sum.bounded += part.bounded;
      sum.turns += part.turns;
    }
    return sum.turns >= least_turns && sum.bounded >= least_bounded_share * sum.cycles &&
           sum.cycles == num_parts * cycles_per_part_;
  }

  double least_way_;
  std::uint32_t cycles_per_part_;
  std::array<Part, num_parts> parts_{};
  std::size_t newest_ = 0;
  double extreme_ = 0;
  bool rising_ = true;
};

}  // namespace godobject
