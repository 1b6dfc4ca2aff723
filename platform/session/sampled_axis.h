// An axis with its feedback in software: the damping that it needs to be passive, and its growth in a period.
// docs/theory/passivity.md derives both.
#pragma once

#include <Eigen/Core>

namespace godobject {

/// Axis with a spring and a damper in software, sampled once a period: m q'' = -b q' + u + hand.
/// The torque u = -K q_k - B (q_k - q_(k-1)) / T + m_c a_k is held for a period, from `delay` periods after
/// sample k. a_k is the acceleration of hal/rig/inertia_compensation.h.
struct SampledAxis {
  double inertia = 1;      // m, kg m^2 or kg, > 0
  double damping = 0;      // b, the device's own, N m s/rad or N s/m
  double K = 0;            // stiffness, N m/rad or N/m
  double B = 0;            // damping of the feedback, N m s/rad or N s/m
  double period_s = 1e-3;  // T, s
  int delay = 1;           // whole periods from the sample to the torque
  double carried = 0;      // m_c, inertia that the drive moves, kg m^2 or kg
  double cutoff = 1;       // of a_k, rad/s, > 0

  /// Returns the smallest b of a passive axis, K (T/2 + t_d) + |B| and that of the carried inertia, with
  /// t_d = delay T.
  double needed() const noexcept { return needed_for_feedback() + needed_for_inertia(); }
  double needed_for_feedback() const noexcept;
  /// Returns the smallest b at which the torques of the carried inertia alone give no energy.
  double needed_for_inertia() const noexcept;
  double margin() const noexcept { return damping - needed(); }
  bool passive() const noexcept { return margin() >= 0; }
};

/// Returns the largest growth factor of the motion per period, with a hand of this stiffness and damping. The
/// axis is stable below 1.
double growth_per_period(const SampledAxis& axis, double hand_stiffness = 0, double hand_damping = 0);

/// Returns the smallest B at which an axis without spring and own damping is unstable: 2 m/T without delay,
/// 0.83 m/T with one period of delay.
double largest_stable_damping(double inertia, double period_s, int delay);

/// Returns the largest absolute eigenvalue of a square matrix.
double spectral_radius(Eigen::MatrixXd A);

}  // namespace godobject
