// Target of a hand that another thread streams to the loop, such as the pointer of a page or a SpaceMouse.
// Samples arrive wait-free and are interpolated within limits of speed. They become stale after some time
// without a new one.
#pragma once

#include <cstdint>

#include "core/math/rotation_error.h"
#include "core/math/so3.h"
#include "hal/tracker/pose_track.h"
#include "platform/motion/motion.h"
#include "platform/rt/ring.h"

namespace godobject {

/// One sample of the hand.
struct StreamedSample {
  enum class State : std::uint8_t {
    rests,  // at rest until the next sample, however late
    leads,  // moving: stale if the next sample is late
    lost,   // unknown
  };
  Pose X_WD;
  State state = State::rests;
  std::uint32_t path = 0;     // a changed number starts a new path at another place
  HoldWish wish{};            // body to hold, from a hand that selects it
  bool clutch = true;         // closed
  std::uint32_t presses = 0;  // counts presses of the grip button
  Nanoseconds t = 0;
};

/// Limits of the target's motion; motion beyond them is left out.
struct StreamLimits {
  Nanoseconds stale_after = 0;
  double speed = 0, turn_rate = 0;  // m/s, rad/s
};

class StreamedTarget {
 public:
  StreamedTarget(const StreamedSample& start, const StreamLimits& limits);

  /// Adds a sample, from the hand's thread. Drops it if the ring is full, which occurs only if the loop
  /// stands still.
  void push(const StreamedSample& sample) noexcept { static_cast<void>(samples_.try_push(sample)); }

  // For the loop:

  /// Updates the target; to be called once a period. step: s.
  void play(Nanoseconds now, double step) noexcept;
  const Target& target() const noexcept { return shown_; }
  bool valid() const noexcept { return valid_; }
  /// The newest sample, and the newest one of a period ago.
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

/// Returns a, shortened to the length `most` if longer.
inline Vec3 limited(const Vec3& a, double most) noexcept {
  const double length = a.norm();
  return length > most ? Vec3(a * (most / length)) : a;
}

/// Returns the pose X displaced by dp_W, m, and rotated about its own origin by dphi_W, rad, in world axes.
inline Pose moved_by(const Pose& X, const Vec3& dp_W, const Vec3& dphi_W) noexcept {
  return {.p = X.p + dp_W, .q = renormalized(exp_so3(dphi_W) * X.q)};
}

inline StreamedTarget::StreamedTarget(const StreamedSample& start, const StreamLimits& limits)
    : limits_(limits),
      heard_(start),
      before_(start),
      track_(limits.stale_after),
      shown_{.X_WD = start.X_WD, .V_WD = {}} {}

inline void StreamedTarget::play(Nanoseconds now, double step) noexcept {
  before_ = heard_;
  for (StreamedSample sample; samples_.try_pop(sample); heard_ = sample) {
    if (sample.path != heard_.path) {
      track_ = PoseTrack(limits_.stale_after);
      shown_ = {.X_WD = sample.X_WD, .V_WD = {}};
    }
    track_.push(sample.X_WD, sample.t, now);
  }
  const PoseTrack::Played played = track_.at(now);
  follow(played, step);
  using State = StreamedSample::State;
  valid_ = heard_.state == State::rests || (heard_.state == State::leads && played.valid);
}

/// Moves the displayed target towards the played one, within the limits. At rest if none is played.
inline void StreamedTarget::follow(const PoseTrack::Played& played, double step) noexcept {
  shown_.V_WD = {};
  if (!played.valid) return;
  Pose& X = shown_.X_WD;
  const RotationError turn = rotation_error(X.q, played.target.X_WD.q, Vec3::Zero());
  const Vec3 dp_W = limited(played.target.X_WD.p - X.p, step * limits_.speed);
  const Vec3 dphi_W = limited(to_world(X.q, turn.phi_B), step * limits_.turn_rate);
  X = moved_by(X, dp_W, dphi_W);
  shown_.V_WD = {.w = dphi_W / step, .v = dp_W / step};
}

}  // namespace godobject
