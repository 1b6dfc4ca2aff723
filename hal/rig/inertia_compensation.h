// Torque by which a drive moves its device's own inertia, from the samples of the joint's sensor.
#pragma once

#include <algorithm>
#include <cmath>

namespace godobject {

/// The acceleration of a sampled coordinate behind two equal low-passes of first order is
/// (q - 2 LP(q) + LP(LP(q))) / t_c^2, without any difference of neighbouring samples.
class InertiaCompensation {
 public:
  /// inertia: m_c, kg m^2 or kg; 0: no torque. cutoff: of each low-pass, rad/s, > 0. period_s: T, s, > 0.
  explicit InertiaCompensation(double inertia = 0, double cutoff = 1, double period_s = 1e-3) noexcept
      : share_(share_of(cutoff, period_s)), gain_(inertia * gain_of(cutoff, period_s)) {}

  /// Returns the share c of a new sample in the low-pass y + c (q - y).
  static double share_of(double cutoff, double period_s) noexcept { return -std::expm1(-cutoff * period_s); }
  /// Returns the factor of q - 2 LP(q) + LP(LP(q)) with which a constant acceleration is displayed exactly.
  static double gain_of(double cutoff, double period_s) noexcept {
    const double c = share_of(cutoff, period_s), t = (1 - c) * period_s;
    return c * c / (t * t);
  }

  /// Begins again with the next sample, at rest.
  void reset() noexcept { has_sample_ = false; }

  /// Returns m_c q'', N m or N. q: last sample. is_new: false if it was passed before. is_valid: false
  /// restarts the filter. Call it once a period. Missing samples are taken as equally spaced.
  double update(double q, bool is_new, bool is_valid) noexcept {
    if (gain_ == 0) return 0;
    ++periods_;
    if (!is_valid || periods_ > max_periods) has_sample_ = false;
    if (!is_valid || (has_sample_ && !is_new)) return has_sample_ ? torque_ : 0;
    if (!has_sample_) start(q);
    const double from = q_;
    for (int i = 1; i <= periods_; ++i) filter(from + (q - from) * i / periods_);
    periods_ = 0;
    return torque_;
  }

 private:
  static constexpr int max_periods = 16;  // between two samples

  void start(double q) noexcept {
    has_sample_ = true;
    q_ = once_ = twice_ = q;
    periods_ = 1;
  }

  void filter(double q) noexcept {
    q_ = q;
    once_ += share_ * (q - once_);
    twice_ += share_ * (once_ - twice_);
    torque_ = gain_ * (q - 2 * once_ + twice_);
  }

  double share_, gain_;
  bool has_sample_ = false;
  int periods_ = 0;  // since the last new sample
  double q_ = 0, once_ = 0, twice_ = 0, torque_ = 0;
};

}  // namespace godobject
