// The target of a hand that another thread streams to the loop: samples come wait-free, are played back without stairs, no
// faster than allowed, and are stale after some time without one. The pointer of a page and a SpaceMouse are read so.
#pragma once

#include <cstdint>

#include "hal/tracker/pose_track.h"
#include "platform/motion/motion.h"
#include "platform/rt/ring.h"

namespace godobject {

/// What a hand says of itself.
struct StreamedSample {
  enum class State : std::uint8_t {
    rests,  // it moves nothing, for as long as it says nothing else
    leads,  // it moves its target: stale where the next sample does not come
    lost,   // nobody knows
  };
  Pose X_WD;
  State state = State::rests;
  std::uint32_t path = 0;     // another number: a new path begins, elsewhere
  HoldWish wish{};            // of a hand that says what it holds
  bool clutch = true;         // closed
  std::uint32_t presses = 0;  // counts those of the button that takes hold
  Nanoseconds t = 0;
};

/// Faster its target does not move: what a sample asks for beyond is left out.
struct StreamLimits {
  Nanoseconds stale_after = 0;
  double speed = 0, turn_rate = 0;  // m/s, rad/s
};

class StreamedTarget {
 public:
  StreamedTarget(const StreamedSample& start, const StreamLimits& limits);

  /// The hand's thread. A ring that is full is one of a loop that stands still: the sample is left out.
  void push(const StreamedSample& sample) noexcept { static_cast<void>(samples_.try_push(sample)); }

  // The loop:

  /// Once a period. step: s.
  void play(Nanoseconds now, double step) noexcept;
  const Target& target() const noexcept { return shown_; }
  bool valid() const noexcept { return valid_; }
  /// The newest sample, and the one that was newest a period ago.
  const StreamedSample& heard() const noexcept { return heard_; }
  const StreamedSample& heard_before() const noexcept { return before_; }

 private:
  void follow(const PoseTrack::Played& played, double step) noexcept;

  Ring<StreamedSample> samples_{64};
  StreamLimits limits_;
  StreamedSample heard_, before_;
  PoseTrack track_;
  Target shown_;
  bool valid_ = true;
};

/// a, or what has its direction and this length where it is longer.
Vec3 limited(const Vec3& a, double most) noexcept;
/// Shifted and turned about its own origin, world axes.
Pose moved_by(const Pose& X, const Vec3& dp_W, const Vec3& dphi_W) noexcept;

}  // namespace godobject
