#include "hal/tracker/pose_track.h"

#include <algorithm>
#include <cmath>

namespace godobject {
namespace {

// Limits of the playback rate while the delay is corrected, relative to real time, and of its rate of change.
// The coupling's damper displays a change of the rate, because it changes the velocity.
constexpr double max_slower = 0.05, max_faster = 0.02;
constexpr double rate_slew = 0.5;  // 1/s
constexpr double correction_time_ns = 100e6;
constexpr double forgetting = 1e-3;  // decrease per sample, relative to the largest delay

}  // namespace

void PoseTrack::push(const Pose& X, Nanoseconds t, Nanoseconds now) noexcept {
  if (size_ > 0 && t <= sample(0).t) return;
  if (size_ > 0 && t - sample(0).t > stale_after_) {
    size_ = 0;
    playing_ = false;
  }
  Sample added{.X = X, .t = t, .knot = t};
  if (size_ > 0) {
    const Sample& before = sample(0);
    const Nanoseconds period = t - before.t;
    if (X.q.dot(before.X.q) < 0) added.X.q.coeffs() = -X.q.coeffs();
    added.knot = std::max(t + period / 2, before.knot + period / 4);
  }
  if (size_ >= 3) {  // the first sample has no knot
    // Delay that was needed until this sample: the path ended at the knot of the sample before the last.
    const Nanoseconds needed = now - sample(1).knot;
    const auto excess = static_cast<double>(wanted_delay_ - needed);
    wanted_delay_ = size_ == 3
                        ? needed
                        : std::max<Nanoseconds>(needed, wanted_delay_ - std::llround(forgetting * excess));
  }
  samples_[next_] = added;
  next_ = (next_ + 1) % capacity;
  size_ = std::min(size_ + 1, capacity);
}

PoseTrack::Played PoseTrack::at(Nanoseconds now) noexcept {
  Played played;
  if (size_ == 0) return played;
  played.age = now - sample(0).t;
  played.target.X_WD = sample(0).X;
  played.valid = size_ >= 4 && played.age <= stale_after_;
  if (!played.valid) {
    playing_ = false;
    return played;
  }
  adapt_delay(now);
  const Nanoseconds play = now - delay_;
  // The span of sample i is between the knots of i-1 and i and uses the samples i-1 to i+1.
  std::size_t back = 1;
  while (back + 3 < size_ && sample(back + 1).knot > play) ++back;
  if (back == 1 && play > sample(1).knot) {
    played.target = coming_to_rest(play);
  } else {
    played.target = spline(back, std::max(play, sample(back + 1).knot));
  }
  played.target.V_WD.v *= 1 - slowdown_;
  played.target.V_WD.w *= 1 - slowdown_;
  return played;
}

void PoseTrack::adapt_delay(Nanoseconds now) noexcept {
  const auto dt = static_cast<double>(now - last_);
  if (!playing_) {
    delay_ = wanted_delay_;
    slowdown_ = 0;
  } else if (dt > 0) {
    const double wanted =
        std::clamp(static_cast<double>(wanted_delay_ - delay_) / correction_time_ns, -max_faster, max_slower);
    const double max_change = 1e-9 * rate_slew * dt;
    slowdown_ = std::clamp(wanted, slowdown_ - max_change, slowdown_ + max_change);
    delay_ += std::llround(slowdown_ * dt);
    if (now - delay_ > sample(1).knot && last_ - delay_ <= sample(1).knot) ++late_;
  }
  playing_ = true;
  last_ = now;
}

/// De Boor's recursion. Quaternions are interpolated by component, then normalised; w = 2 q' q*.
Target PoseTrack::spline(std::size_t back, Nanoseconds play) const noexcept {
  const Sample &before = sample(back + 1), &here = sample(back), &after = sample(back - 1);
  const Nanoseconds u0 = sample(back + 2).knot, u1 = before.knot, u2 = here.knot, u3 = after.knot;
  const auto share = [&](Nanoseconds from, Nanoseconds to) {
    return static_cast<double>(to - play) / static_cast<double>(to - from);
  };
  const double a = share(u0, u2), b = share(u1, u3), c = share(u1, u2);
  const double per_s = 2 / (1e-9 * static_cast<double>(u2 - u1));
  const double w0 = c * a, w2 = (1 - c) * (1 - b), w1 = 1 - w0 - w2;    // weights of the value
  const double r0 = -per_s * a, r2 = per_s * (1 - b), r1 = -(r0 + r2);  // weights of the rate
  Target target;
  target.X_WD.p = w0 * before.X.p + w1 * here.X.p + w2 * after.X.p;
  target.V_WD.v = r0 * before.X.p + r1 * here.X.p + r2 * after.X.p;
  const Eigen::Vector4d q = w0 * before.X.q.coeffs() + w1 * here.X.q.coeffs() + w2 * after.X.q.coeffs();
  const Eigen::Vector4d q_dot = r0 * before.X.q.coeffs() + r1 * here.X.q.coeffs() + r2 * after.X.q.coeffs();
  target.X_WD.q.coeffs() = q.normalized();
  target.V_WD.w = (2 / q.squaredNorm()) * (Quat(q_dot) * Quat(q).conjugate()).vec();
  return target;
}

/// Returns the target after the last span: constant deceleration to rest within one more period.
Target PoseTrack::coming_to_rest(Nanoseconds play) const noexcept {
  const Nanoseconds end = sample(1).knot;
  const Target last = spline(1, end);
  const auto period = static_cast<double>(sample(0).t - sample(1).t);
  const double tau = std::min(static_cast<double>(play - end), period);
  const double way = 1e-9 * (tau - tau * tau / (2 * period)), speed = 1 - tau / period;
  const Vec3 turn = way * last.V_WD.w;
  const double angle = turn.norm();
  const Quat turned(Eigen::AngleAxisd(angle, angle > 0 ? Vec3(turn / angle) : Vec3(Vec3::UnitX())));
  return {.X_WD = {.p = last.X_WD.p + way * last.V_WD.v, .q = turned * last.X_WD.q},
          .V_WD = {.w = speed * last.V_WD.w, .v = speed * last.V_WD.v}};
}

}  // namespace godobject
