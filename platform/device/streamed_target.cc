#include "platform/device/streamed_target.h"

#include "core/math/rotation_error.h"
#include "core/math/so3.h"

namespace godobject {

Vec3 limited(const Vec3& a, double most) noexcept {
  const double length = a.norm();
  return length > most ? Vec3(a * (most / length)) : a;
}

Pose moved_by(const Pose& X, const Vec3& dp_W, const Vec3& dphi_W) noexcept {
  return {.p = X.p + dp_W, .q = renormalized(exp_so3(dphi_W) * X.q)};
}

StreamedTarget::StreamedTarget(const StreamedSample& start, const StreamLimits& limits)
    : limits_(limits),
      heard_(start),
      before_(start),
      track_(limits.stale_after),
      shown_{.X_WD = start.X_WD, .V_WD = {}} {}

void StreamedTarget::play(Nanoseconds now, double step) noexcept {
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
void StreamedTarget::follow(const PoseTrack::Played& played, double step) noexcept {
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
