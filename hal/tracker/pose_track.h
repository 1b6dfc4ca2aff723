// Converts a slow, delayed source of poses to a target for every step of the core. The path is played with a
// delay such that the next sample arrives before it is needed (docs/decisions/020-tracker-poses.md).
#pragma once

#include <array>
#include <cstddef>

#include "core/body/target.h"
#include "hal/base/nanoseconds.h"

namespace godobject {

/// Samples of one tool. The path is the quadratic B-spline with the samples as control points. Position and
/// velocity are continuous for any sampling times, and noise is not amplified. After the last sample it comes
/// to rest within one period. Fixed memory; no call allocates.
class PoseTrack {
 public:
  /// Samples between the newest one and the playback: 0.5 s at 120 Hz, 0.16 s at 400 Hz.
  static constexpr std::size_t capacity = 64;

  explicit PoseTrack(Nanoseconds stale_after) noexcept : stale_after_(stale_after) {}

  /// Adds a pose. t: measurement time, ns. now: arrival time, ns. A sample not newer than the last is
  /// ignored; after a gap above stale_after the track restarts.
  void push(const Pose& X, Nanoseconds t, Nanoseconds now) noexcept;

  struct Played {
    Target target;
    bool valid = false;   // at least four samples exist and the newest is not older than stale_after
    Nanoseconds age = 0;  // age of the newest sample
  };
  /// Returns the target at `now`; its path time never decreases. If not valid: the pose of the newest sample.
  Played at(Nanoseconds now) noexcept;

  /// Returns the delay of the playback relative to the measurement, ns.
  Nanoseconds delay() const noexcept { return delay_; }
  /// Returns how often the playback was slowed down because a sample was later than all recent ones.
  std::uint64_t late() const noexcept { return late_; }

 private:
  struct Sample {
    Pose X;
    Nanoseconds t = 0;
    Nanoseconds knot = 0;  // knot of the spline: half a period after t
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
  Nanoseconds wanted_delay_ = 0;  // delay at which the next sample would always arrive in time
  Nanoseconds delay_ = 0;
  double slowdown_ = 0;   // slowdown of the playback relative to real time, while the delay is corrected
  Nanoseconds last_ = 0;  // `now` of the last at()
  bool playing_ = false;
  std::uint64_t late_ = 0;
};

}  // namespace godobject
