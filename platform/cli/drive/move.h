// A short, slow move of one drive, to check motor, sensor and signs.
#pragma once

#include <atomic>

#include "platform/cli/drive/dialogue.h"

namespace godobject {

/// Trapezoidal profile with ramps of a quarter of the duration each: rate() from 0 to 1 to 0, and way(), its
/// integral, from 0 to 1.
class MoveRamp {
 public:
  explicit constexpr MoveRamp(double duration) noexcept : duration_(duration), ramp_(duration / 4) {}

  constexpr double rate(double t) const noexcept {
    const double from_end = duration_ - t;
    const double nearest = t < from_end ? t : from_end;
    return nearest <= 0 ? 0 : nearest >= ramp_ ? 1 : nearest / ramp_;
  }
  /// Returns the integral of rate() up to t, divided by the integral over the whole duration.
  constexpr double way(double t) const noexcept {
    if (t <= 0) return 0;
    if (t >= duration_) return 1;
    const double from_end = duration_ - t;
    if (t < ramp_) return t * t / (2 * ramp_) / area();
    if (from_end < ramp_) return 1 - from_end * from_end / (2 * ramp_) / area();
    return (t - ramp_ / 2) / area();
  }
  /// Returns the largest rate of change of way(), 1/s.
  constexpr double peak_rate() const noexcept { return 1 / area(); }

 private:
  constexpr double area() const noexcept { return duration_ - ramp_; }
  double duration_, ramp_;
};

struct MoveOptions {
  cia402::CommandKind kind = cia402::CommandKind::velocity;
  double value = 0;     // counts/s, relative counts, or per mille of 6076h
  double duration = 1;  // s
};

/// Powers the drive, moves it and turns it off; prints the drive's values five times a second. Ends early if
/// `stop` is set or an error occurs, which it prints to stderr.
ExitCode move_drive(DriveDialogue& drive, const MoveOptions& options, const std::atomic<bool>& stop);

}  // namespace godobject
