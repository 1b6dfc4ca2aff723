// From a slow, late source of poses to a target for every step of the core: the path is played back a little later than
// it was measured, so that the next sample is there before it is needed (docs/decisions/020-tracker-poses.md).
#pragma once

#include <array>
#include <cstddef>

#include "core/body/target.h"
#include "hal/can/frame.h"

namespace godobject {

/// Samples of one tool. The path is the quadratic B-spline that has the samples as its control points: position and
/// velocity are continuous whatever the times of the samples are, and their noise is not made larger. Where samples stop
/// it comes to rest within one period. Fixed memory; no call allocates.
class PoseTrack {
 public:
  /// Samples that lie between the newest one and the playback: 0.5 s at 120 Hz, 0.16 s at 400 Hz.
  static constexpr std::size_t capacity = 64;

  explicit PoseTrack(Nanoseconds stale_after) noexcept : stale_after_(stale_after) {}

  /// A pose measured at `t` and known at `now`. One that is not newer than the last is ignored; after a gap of more than
  /// stale_after the track begins anew.
  void push(const Pose& X, Nanoseconds t, Nanoseconds now) noexcept;

  struct Played {
    Target target;
    bool valid = false;   // four samples are there and the newest one is not older than stale_after
    Nanoseconds age = 0;  // of the newest sample
  };
  /// The target at `now`, which never goes back. Not valid: the pose of the newest sample.
  Played at(Nanoseconds now) noexcept;

  /// How much later than measured the path is played.
  Nanoseconds delay() const noexcept { return delay_; }
  /// Times at which it had to be slowed down because the next sample was later than ever lately.
  std::uint64_t late() const noexcept { return late_; }

 private:
  struct Sample {
    Pose X;
    Nanoseconds t = 0;
    Nanoseconds knot = 0;  // of the spline: half a period after t
  };

  const Sample& sample(std::size_t back) const noexcept {
    return samples_[(next_ + capacity - 1 - back) % capacity];
  }
  void adapt_delay(Nanoseconds now) noexcept;
  Target spline(std::size_t back, Nanoseconds play) const noexcept;
  Target coming_to_rest(Nanoseconds play) const noexcept;

  Nanoseconds stale_after_;
  std::array<Sample, capacity> samples_{};
  std::size_t size_ = 0, next_ = 0;
  Nanoseconds wanted_delay_ = 0;  // at which the next sample would always be in time
  Nanoseconds delay_ = 0;
  double slowdown_ = 0;   // of the playback against real time, while the delay is corrected
  Nanoseconds last_ = 0;  // now of the last at()
  bool playing_ = false;
  std::uint64_t late_ = 0;
};

}  // namespace godobject
