// Displayed wrench: the feedback (8) with its own gains, bounded in size and rate.
#pragma once

#include "core/body/coupling.h"
#include "core/device/device.h"

namespace godobject {

struct FeedbackParams {
  SpringParams gains;         // g_d, k_d, g_dr, k_dr of (8)
  Real max_force = 10;        // N
  Real max_torque = 0.5;      // N m
  Real max_force_rate = 500;  // N/s
  Real max_torque_rate = 25;  // N m/s
};

/// Moves a wrench on a link, about the link's origin, to its parent link (9): f, tau + (x - x_parent) x f.
inline Wrench moved_to_parent(const Wrench& F, const Vec3& x, const Vec3& x_parent) noexcept {
  return {.tau = F.tau + (x - x_parent).cross(F.f), .f = F.f};
}

/// Returns `a` shortened to the length `bound`; sets `bit` if it was longer. Zero if the length overflows.
inline Vec3 bounded(const Vec3& a, Real bound, Limited bit, Limited& limited) noexcept {
  const Real length_sq = a.squaredNorm();
  if (length_sq <= bound * bound) return a;
  limited |= bit;
  if (!(length_sq - length_sq == 0)) return Vec3::Zero();
  return a * (bound / std::sqrt(length_sq));
}

struct LimitedFeedback {
  using Params = FeedbackParams;
  struct State {
    Wrench F_D;  // wrench displayed in the last step
    // Displayed force and torque at the first sample after a gap, N and N m.
    Real force_at_return = 0;
    Real torque_at_return = 0;
  };
  struct Output {
    Wrench F_D;  // displayed on the device at the target's origin, world axes
  };

  /// Returns the feedback (8):  F = g_d (v - v_D) + k_d (x - x_D),  T = g_dr (w - w_D) - k_dr alpha u
  static Wrench wrench(const SpringParams& gains, const RigidBodyState& x, const Target& target,
                       const Vec3& phi_B) noexcept {
    const Quat& q = x.X_WB.q;
    return {.tau = gains.g_r * (to_world(q, x.w_B) - target.V_WD.w) - gains.k_r * to_world(q, phi_B),
            .f = gains.g * (x.v_W - target.V_WD.v) + gains.k * (x.X_WB.p - target.X_WD.p)};
  }

  /// Moves the displayed wrench towards `wanted` within the limits.
  static void show(const Params& par, const Wrench& wanted, Real h, State& x, Output& out,
                   Limited& limited) noexcept {
    const Real shown = x.F_D.f.sum() + x.F_D.tau.sum();
    if (!(shown - shown == 0)) x.F_D = {};  // keeps a damaged state from the hand
    move(par, in_size(par, wanted, limited), h, x, out, limited);
  }

  /// Moves the displayed wrench towards `wanted` as far as the gap in the samples allows.
  static void show(const Params& par, const Gap& gap, const Wrench& wanted, Real h, State& x, Output& out,
                   Limited& limited) noexcept {
    if (gap.showing == Showing::all) return show(par, wanted, h, x, out, limited);
    show_after_gap(par, gap, wanted, h, x, out, limited);
  }

 private:
  /// Returns `wanted`, shortened to the configured size.
  static Wrench in_size(const Params& par, const Wrench& wanted, Limited& limited) noexcept {
    return {.tau = bounded(wanted.tau, par.max_torque, Limited::torque, limited),
            .f = bounded(wanted.f, par.max_force, Limited::force, limited)};
  }

  /// Moves the displayed wrench towards F, at most at the configured rate.
  static void move(const Params& par, const Wrench& F, Real h, State& x, Output& out,
                   Limited& limited) noexcept {
    x.F_D.f += bounded(F.f - x.F_D.f, h * par.max_force_rate, Limited::force_rate, limited);
    x.F_D.tau += bounded(F.tau - x.F_D.tau, h * par.max_torque_rate, Limited::torque_rate, limited);
    out.F_D = x.F_D;
  }

  [[gnu::noinline]] static void show_after_gap(const Params& par, const Gap& gap, const Wrench& wanted,
                                               Real h, State& x, Output& out, Limited& limited) noexcept {
    if (gap.showing == Showing::still) return show(par, x.F_D, h, x, out, limited);
    if (gap.showing == Showing::fading) return show(par, {}, h, x, out, limited);
    if (gap.back) {
      x.force_at_return = x.F_D.f.norm();
      x.torque_at_return = x.F_D.tau.norm();
    }
    // A bound by the gap is part of the ramp and not a configurable limit, so no limit bit is set.
    const Wrench F = in_size(par, wanted, limited);
    const Vec3 f = bounded(F.f, x.force_at_return + gap.growth * par.max_force, Limited::ramp, limited);
    const Vec3 tau = bounded(F.tau, x.torque_at_return + gap.growth * par.max_torque, Limited::ramp, limited);
    move(par, {.tau = tau, .f = f}, h, x, out, limited);
  }
};

}  // namespace godobject
