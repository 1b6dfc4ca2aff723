// Passivity observer and controller of one driven axis (Hannaford and Ryu, IEEE Trans. Robotics and
// Automation 18(1), 2002). Derivation and measurements: docs/theory/passivity.md,
// docs/decisions/069-passivity-controller.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace godobject {

struct PassivityParams {
  double inertia = 1;      // m of the axis, kg m^2 or kg, > 0
  double damping = 0;      // b, the device's own, N m s/rad or N s/m
  double needed = 0;       // smallest b of a passive axis, as above; no controller up to b
  double stiffness = 0;    // K of the wanted torque, N m/rad or N/m
  double resolution = 0;   // one count of the sensor, rad or m
  double period_s = 1e-3;  // T, s, > 0
  int delay = 1;           // whole periods from the sample to its torque, >= 0
  int acts_after = 1;      // whole periods from sending a torque to its effect, 0 to max_acts_after
  double energy_J = 1e-5;  // generated energy at which the controller acts fully; 0: no controller
  double carried = 0;      // inertia m_c that the drive moves for the hand, kg m^2 or kg, >= 0

  static constexpr int max_acts_after = 6;

  double deficit() const noexcept { return std::max(0.0, needed - damping); }
  bool is_active() const noexcept { return energy_J > 0 && deficit() > 0; }
};

/// Observes the energy that sampling, delay and limits add to an axis, and bounds it.
///
/// The observer compares the work of the sent torque with that of the wanted torque acting without delay,
/// by the trapezoidal rule between samples. The difference is generated energy, from which the device's own
/// damping removes b dq^2 / T. Dissipated energy is not stored, so that a long dissipative past
/// permits no burst. The energy of the simulated scene itself is in both and cancels. Torques that move the
/// device's own inertia may have put in m_c q'^2 / 2, which the hand returns when it stops the device.
///
/// With generated energy the controller displays a softened torque and adds damping. The softened torque
/// follows changes of the wanted one as a spring of `soft_stiffness` at most, which is passive at this period
/// and delay. It converges to the wanted torque within `relaxation_s`, so that rest and slow motion feel the
/// whole stiffness. Torques that move inertia fade by the controller's share. In free motion the added
/// damping then takes back the energy lent. Without generated energy the wanted torque is returned unchanged.
class PassivityController {
 public:
  // Softened stiffness in m / ((d + 1) T)^2 and its damping in m / ((d + 1) T).
  static constexpr double stiffness_share = 0.05, damping_share = 0.35;
  /// Unloading faster than `slow_counts` per sample is this much stiffer than loading: impacts lose energy.
  static constexpr double unloading = 6, slow_counts = 1.5;
  /// Damping in free motion that takes back energy lent to a carried inertia, in deficits.
  static constexpr double recovery = 12;
  /// Shortest time in which the softened torque converges. Convergence is an integral term, which is stable
  /// if much slower than soft_stiffness * soft_damping / (m K).
  static constexpr double relaxation_s = 1, relaxation_margin = 5;
  /// Time constant in which generated energy above this multiple of energy_J is forgotten.
  static constexpr double forgotten_s = 3, remembered = 2;
  static constexpr double release_s = 1;  // time constant of the controller's fading
  static constexpr double velocity_weight = 0.4;

  explicit PassivityController(const PassivityParams& params = {}) noexcept
      : params_(params),
        soft_stiffness_(stiffness_share * params.inertia / square(reach_s())),
        soft_share_(params.stiffness > soft_stiffness_ ? soft_stiffness_ / params.stiffness : 1),
        soft_damping_(std::min(damping_share * params.inertia / reach_s(), 2 * params.deficit())),
        recovery_damping_(std::min(damping_share * params.inertia / reach_s(), recovery * params.deficit())),
        relaxed_per_period_(params.period_s /
                            std::max(relaxation_s, relaxation_margin * params.stiffness * params.inertia /
                                                       (soft_stiffness_ * soft_damping_))) {}

  /// Forgets all samples and energy, for an axis without torque.
  void reset() noexcept { *this = PassivityController(params_); }

  /// Returns the torque to send instead of `wanted + moving`, at the joint. q: last sample of the joint
  /// coordinate. is_new: false if the sample was returned before, or is not valid. moving: torque that moves
  /// the carried inertia. Call it once a period, then sent().
  double limit(double wanted, double q, bool is_new, double moving = 0) noexcept {
    if (!params_.is_active()) return wanted + moving;
    ++periods_;
    work_rate_ += sent_[next_];
    if (!has_sample_) start(wanted, q);
    else if (is_new) observe(wanted, q);
    share_ *= 1 - params_.period_s / release_s;
    share_ = std::max(share_, std::min(1.0, energy_J() / params_.energy_J));
    const double soft = soften(wanted);
    wanted_ = wanted;
    if (share_ < least_share) return wanted + moving;
    if (params_.carried > 0 && wanted == 0)
      return (1 - share_) * moving - share_ * recovery_damping_ * q_dot_;
    const double torque = wanted + share_ * (soft - wanted - (wanted != 0 ? soft_damping_ * q_dot_ : 0));
    return (torque * wanted < 0 ? 0 : torque) + (1 - share_) * moving;
  }

  /// Records the torque that was sent after all limits, at the joint.
  void sent(double torque) noexcept {
    sent_[next_] = torque;
    next_ = (next_ + 1) % (static_cast<std::size_t>(params_.acts_after) + 1);
  }

  /// Returns the generated energy that is not yet dissipated, J.
  double energy_J() const noexcept { return std::max(0.0, added_J_ - lent_J()); }
  /// Returns the present share of the softened torque, 0 (idle) to 1.
  double share() const noexcept { return share_ < least_share ? 0 : share_; }

 private:
  static constexpr double least_share = 1e-3;  // below: idle

  static constexpr double square(double x) noexcept { return x * x; }
  double reach_s() const noexcept { return (params_.delay + 1) * params_.period_s; }

  void start(double wanted, double q) noexcept {
    has_sample_ = true;
    sample(wanted, q);
  }

  void sample(double wanted, double q) noexcept {
    q_ = q;
    wanted_at_q_ = wanted;
    periods_ = 0;
    work_rate_ = 0;
  }

  /// Adds the energy since the last sample, with the mean of the torques that acted.
  void observe(double wanted, double q) noexcept {
    const double dq = q - q_;
    const double time_s = periods_ * params_.period_s;
    const double acted = work_rate_ / periods_;
    const double excess = energy_J() - remembered * params_.energy_J;
    if (excess > 0) added_J_ -= excess * std::min(1.0, time_s / forgotten_s);
    added_J_ += (acted - 0.5 * (wanted + wanted_at_q_)) * dq - params_.damping * dq * dq / time_s;
    added_J_ = std::max(added_J_, 0.0);
    q_dot_ += velocity_weight * (dq / time_s - q_dot_);
    moved_ += std::abs(dq);
    sample(wanted, q);
  }

  /// Returns m_c q'^2 / 2.
  double lent_J() const noexcept { return 0.5 * params_.carried * square(q_dot_); }

  /// Moves the softened torque with the wanted one, as far as the axis has moved, and towards it by its rate.
  double soften(double wanted) noexcept {
    const bool unloads = std::abs(wanted) < std::abs(wanted_);
    const double fast = std::max(0.0, moved_ - slow_counts * params_.resolution);
    const double change = wanted - wanted_;
    const double most = std::max(soft_stiffness_ * (moved_ + (unloads ? (unloading - 1) * fast : 0)),
                                 soft_share_ * std::abs(change));
    moved_ = 0;
    soft_ += std::clamp(change, -most, most);
    soft_ += (wanted - soft_) * relaxed_per_period_;
    if (soft_ * wanted <= 0) soft_ = 0;
    return soft_;
  }

  PassivityParams params_;
  double soft_stiffness_, soft_share_, soft_damping_, recovery_damping_, relaxed_per_period_;
  bool has_sample_ = false;
  double q_ = 0, q_dot_ = 0, moved_ = 0;
  double wanted_ = 0, wanted_at_q_ = 0;  // in the last period, at the last new sample
  double soft_ = 0, share_ = 0;
  double added_J_ = 0;    // energy added to the axis and neither dissipated nor returned
  double work_rate_ = 0;  // sum of the torques that acted since the last new sample
  int periods_ = 0;       // number of them
  std::array<double, PassivityParams::max_acts_after + 1> sent_{};  // ring of acts_after + 1 torques
  std::size_t next_ = 0;  // the oldest torque of the ring, which acted in the period that ends now
};

}  // namespace godobject
