// A short, slow move of one drive, to see that motor, sensor and signs are right.
#pragma once

#include <atomic>

#include "platform/cli/drive/dialogue.h"

namespace godobject {

/// A ramp up for the first quarter, a ramp down for the last: 0 to 1 to 0, and how far that leads, 0 to 1.
class MoveRamp {
 public:
  explicit constexpr MoveRamp(double duration) noexcept : duration_(duration), ramp_(duration / 4) {}

  constexpr double rate(double t) const noexcept {
    const double from_end = duration_ - t;
    const double nearest = t < from_end ? t : from_end;
    return nearest <= 0 ? 0 : nearest >= ramp_ ? 1 : nearest / ramp_;
  }
  /// The integral of rate over its whole.
  constexpr double way(double t) const noexcept {
    if (t <= 0) return 0;
    if (t >= duration_) return 1;
    const double from_end = duration_ - t;
    if (t < ramp_) return t * t / (2 * ramp_) / area();
    if (from_end < ramp_) return 1 - from_end * from_end / (2 * ramp_) / area();
    return (t - ramp_ / 2) / area();
  }
  /// The largest rate of change of way(), 1/s.
  constexpr double peak_rate() const noexcept { return 1 / area(); }

 private:
  constexpr double area() const noexcept { return duration_ - ramp_; }
  double duration_, ramp_;
};

struct MoveOptions {
  cia402::CommandKind kind = cia402::CommandKind::velocity;
  double value = 0;     // counts/s; counts from where it stands; per mille of 6076h
  double duration = 1;  // s
};

/// From power off by way of the move to power off, with a line of what the drive says five times a second. Ends
/// early, with power off, when `stop` is set and when anything goes wrong; reports that to stderr.
ExitCode move_drive(DriveDialogue& drive, const MoveOptions& options, const std::atomic<bool>& stop);

}  // namespace godobject
