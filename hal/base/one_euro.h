// One-Euro filter (Casiez, Roussel, Vogel, CHI 2012) of a pose: a low-pass whose cut-off rises with speed. It
// removes tremor of a resting hand and adds little delay to a fast one.
#pragma once

#include <cmath>
#include <numbers>

#include "core/math/types.h"

namespace godobject {

struct OneEuroParams {
  double min_cutoff_hz = 0;         // cut-off at rest, Hz; 0: no filter
  double cutoff_slope_s_per_m = 0;  // increase of the cut-off with speed, Hz per m/s
};

class OneEuro {
 public:
  explicit OneEuro(const OneEuroParams& params) noexcept : params_(params) {}

  /// Returns the filtered pose. dt: time since the previous sample, s, > 0. Returns the first sample
  /// unchanged.
  Pose filter(const Pose& X, double dt) noexcept {
    if (params_.min_cutoff_hz <= 0) return X;
    if (!started_ || !(dt > 0)) {
      started_ = true;
      X_ = X;
      V_ = {};
      return X;
    }
    // One speed for both: a rotation counts as the path of a point at the end of the lever.
    const Quat dq = X.q * X_.q.conjugate();
    const Vec3 turn = 2 * (dq.w() < 0 ? Vec3(-dq.vec()) : Vec3(dq.vec()));
    const double a = smoothing(speed_cutoff_hz, dt);
    V_.v += a * ((X.p - X_.p) / dt - V_.v);
    V_.w += a * (turn / dt - V_.w);
    const double speed = V_.v.norm() + lever_m * V_.w.norm();
    const double b = smoothing(params_.min_cutoff_hz + params_.cutoff_slope_s_per_m * speed, dt);
    X_.p += b * (X.p - X_.p);
    X_.q = X_.q.slerp(b, X.q);
    return X_;
  }

  void reset() noexcept { started_ = false; }

 private:
  static constexpr double speed_cutoff_hz = 1;  // cut-off of the speed estimate, as in the paper
  static constexpr double lever_m = 0.1;        // handle to tip, order of magnitude

  /// Returns the weight of the new value in an exponential mean with this cut-off.
  static double smoothing(double cutoff_hz, double dt) noexcept {
    return 1 / (1 + 1 / (2 * std::numbers::pi * cutoff_hz * dt));
  }

  OneEuroParams params_;
  Pose X_{};
  Twist V_{};
  bool started_ = false;
};

}  // namespace godobject
