// How a device drives a body: what it sends each step, and the target that becomes of it.
// Impedance and non-haptic devices are PoseDevice (with and without feedback).
//
// Gaps in the samples are bridged, held and faded here.
#pragma once

#include <algorithm>

#include "core/body/target.h"
#include "core/fault.h"
#include "core/scene.h"
#include "core/tuning.h"

namespace godobject {

struct RampParams {
  Real rise = 0.5;  // s from engaging to full coupling; 0: at once
  Real lost = 0;  // s (and at least bridged_steps) without a valid sample after which the device engages anew
  Real stale = 0;  // s (and at least bridged_steps) for which the wrench that was shown stays; then it fades
};

/// What of the feedback is shown in a step.
enum class Showing : std::uint8_t {
  all,
  capped,  // again, after a gap: as much as was shown at its end, and the share Pull::growth of the bounds
  still,   // no valid sample: what was shown
  fading,  // none for too long: nothing any more
};

struct RampState {
  Real s = 0;  // ramp of the last step
  bool engaged = false;
};

/// What a gap in the samples makes of a step: of one without a valid sample, and of those after it.
struct Gap {
  Real held = 0;    // s since the last valid sample
  Real calm = 0;    // s until all of the feedback may be shown
  Real growth = 0;  // see Showing::capped
  Showing showing = Showing::all;
  bool again = false;    // calm is after a long gap: the feedback grows meanwhile
  bool bridged = false;  // the target goes on as it moved; without a sample and not bridged it rests
  bool back = false;     // the first valid sample after a gap
  bool anew = false;     // the gap was too long: the device engages anew
};

/// What pulls one body during one step: the target at both ends, and how far the ramp is.
struct Pull {
  Target from, to;        // target at the start and the end of the step, quaternions of one sign
  RampState ramp;         // during this step
  Wrench F_WB;            // force and torque applied by the hand (admittance), in a stage: where it ends
  Wrench F_0_WB, F_1_WB;  // those at the start and the end of the step
  bool live = true;       // false: no valid sample
  bool fresh = false;     // first step after engaging or letting go: no history may be used
  Gap gap;
};

/// What all devices carry over.
struct DeviceState {
  Target last;  // target of the last step
  RampState ramp;
  Real held = 0;       // s since the last valid sample
  Real calm = 0;       // s until all of the feedback may be shown, after a gap
  bool again = false;  // that gap was a long one: the feedback grows meanwhile
  Wrench F_WB;         // applied at the end of the last step, of an admittance device
};

/// The state after the step.
inline DeviceState carried_over(const Pull& pull) noexcept {
  return {.last = pull.to,
          .ramp = pull.ramp,
          .held = pull.gap.held,
          .calm = pull.gap.calm,
          .again = pull.gap.again,
          .F_WB = pull.F_1_WB};
}

/// What a device part's pull() returns: a Pull, or what the part names Pull, which is one and has more.
template <class Device>
struct PullOf {
  using type = Pull;
};
template <class Device>
requires requires { typename Device::Pull; }
struct PullOf<Device> {
  using type = typename Device::Pull;
};

/// A pose shifted and turned, by half a turn at most: what turns faster is not known by its samples.
inline Pose displaced(const Pose& X, const Vec3& dp_W, const Vec3& dphi_W) noexcept {
  return {.p = X.p + dp_W, .q = renormalized(exp_so3(at_most_half_a_turn(dphi_W)) * X.q)};
}
/// A target that goes on as it moved for a time dt.
inline Target carried_on(const Target& x, Real dt) noexcept {
  return {.X_WD = displaced(x.X_WD, dt * x.V_WD.v, dt * x.V_WD.w), .V_WD = x.V_WD};
}

/// A step without a valid sample, or after one. A short gap is bridged. During a longer one the target rests and what
/// was shown fades; after it the device engages anew, by the ramp, since the hand may be anywhere by then. The
/// feedback does not grow until the body has caught up: no gap shows more than there was without it.
[[gnu::noinline]] inline Gap bridge(const RampParams& par, const DeviceState& x, bool valid,
                                    Real h) noexcept {
  const auto longer_than = [h](Real held, Real s) { return held > std::max(s, bridged_steps * h) + h / 2; };
  Gap gap;
  gap.calm = std::max(x.calm - h, Real(0));
  gap.again = x.again && gap.calm > 0;
  if (!valid) {
    gap.held = x.held + h;
    gap.bridged = !longer_than(gap.held, 0);
    gap.showing = longer_than(gap.held, par.stale) ? Showing::fading : Showing::still;
    return gap;
  }
  if (x.held > 0 && longer_than(x.held, par.lost)) {
    gap.anew = gap.again = gap.back = true;
    gap.calm = std::max(par.rise, quiet_after_gap) + growth_after_gap;
  } else if (x.held > 0 && x.calm == 0) {
    gap.calm = calm_per_gap * x.held;
    gap.back = true;
  }
  if (gap.calm == 0) return gap;
  const Real grown = gap.again ? std::max(1 - gap.calm / growth_after_gap, Real(0)) : 0;
  gap.showing = Showing::capped;
  gap.growth = grown * grown;
  return gap;
}

/// The ramp: 0 in the first engaged step, so that engaging moves nothing; then rising linearly to 1. Engaging takes
/// a valid sample, and so does going on after a gap that was too long to be bridged.
inline Pull begin_pull(const RampParams& par, const DeviceState& x, bool wanted, bool valid, Real h,
                       Limited& limited) noexcept {
  RampState before = x.ramp;
  Pull pull;
  pull.live = valid;
  if (!valid || x.held > 0 || x.calm > 0) [[unlikely]] {
    pull.gap = bridge(par, x, valid, h);
    if (pull.gap.anew) before = {};
    if (!valid) limited |= Limited::held;
    if (pull.gap.showing == Showing::capped) limited |= Limited::ramp;
  }
  const bool engage = wanted && (valid || before.engaged);
  pull.fresh = engage != before.engaged || engage != x.ramp.engaged;
  pull.ramp.engaged = engage;
  if (!engage) return pull;
  if (before.s == 1 || par.rise <= h) {
    pull.ramp.s = 1;
  } else {
    pull.ramp.s = pull.fresh ? 0 : std::min(Real(1), before.s + h / par.rise);
    limited |= Limited::ramp;
  }
  return pull;
}

/// Engaged before a gap that was not longer than a grip lasts.
inline bool grip_lasted(const DeviceState& x) noexcept { return x.ramp.engaged && x.held <= grip_lasts; }

/// A quaternion and its negative are one attitude: takes the one nearer to `reference`.
inline Quat same_sign(const Quat& q, const Quat& reference) noexcept {
  return q.dot(reference) < 0 ? Quat(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

/// Gives an absolute pose: impedance devices, trackers.
struct PoseDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Target target;
    bool valid = true;    // false: no sample this step; the target rests at the last one
    bool engaged = true;  // false: the device drives nothing
  };

  static Pull pull(const Params& par, const Input& in, const RigidBodyState&, Real h, const State& x,
                   Limited& limited) noexcept {
    Pull d = begin_pull(par, x, in.engaged, in.valid, h, limited);
    d.from = x.last;
    d.to = {.X_WD = x.last.X_WD, .V_WD = {}};
    if (in.valid)
      d.to = {.X_WD = {.p = in.target.X_WD.p, .q = renormalized(in.target.X_WD.q)}, .V_WD = in.target.V_WD};
    else if (d.gap.bridged) d.to = carried_on(x.last, h);
    if (d.fresh) d.from = d.to;
    d.to.X_WD.q = same_sign(d.to.X_WD.q, d.from.X_WD.q);
    return d;
  }
};

/// Gives increments of pose, through a clutch: a mouse, or an arm whose workspace is too small.
struct RelativeDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Vec3 dp_W = Vec3::Zero();    // shift since the last sample, m
    Vec3 dphi_W = Vec3::Zero();  // turn since the last sample, rad, |dphi| <= pi
    bool clutch = true;          // false: the device moves, the target does not
    bool valid = true;
    bool engaged = true;
  };

  static Pull pull(const Params& par, const Input& in, const RigidBodyState& body, Real h, const State& x,
                   Limited& limited) noexcept {
    Pull d = begin_pull(par, x, in.engaged, in.valid, h, limited);
    const bool gap_ends = in.valid && x.held > 0 && grip_lasted(x);
    d.from = d.fresh && !gap_ends ? Target{.X_WD = body.X_WB, .V_WD = {}} : x.last;
    d.to.X_WD = d.from.X_WD;
    if (gap_ends) {
      d.to = after_gap(in, x, h);
      if (d.fresh) d.from = d.to;
    } else if (in.clutch && in.valid && x.held == 0) {
      d.to.X_WD = displaced(d.from.X_WD, in.dp_W, in.dphi_W);
      d.to.V_WD = {.w = in.dphi_W / h, .v = in.dp_W / h};
    } else if (!in.valid && d.gap.bridged && !d.fresh) {
      d.to = carried_on(x.last, h);
    }
    return d;
  }

 private:
  /// The increments are those of the whole gap, of which the bridge has gone a part, should the target still move. After
  /// a gap longer than a grip lasts they are left out: the device engages where the body is.
  static Target after_gap(const Input& in, const State& x, Real h) noexcept {
    const Real bridged = std::min(x.held, bridged_steps * h), since = x.held + h, open = in.clutch ? 1 : 0;
    const Vec3 dp_W = open * in.dp_W - bridged * x.last.V_WD.v,
               dphi_W = open * in.dphi_W - bridged * x.last.V_WD.w;
    return {.X_WD = displaced(x.last.X_WD, dp_W, dphi_W),
            .V_WD = {.w = (open / since) * in.dphi_W, .v = (open / since) * in.dp_W}};
  }
};

/// Gives forces and takes poses. Its spring (if any) is tied to where the body was when engaged.
struct AdmittanceDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Wrench F_WB;  // of the hand on the body, about its centre of mass
    bool valid = true;
    bool engaged = true;
  };

  static Pull pull(const Params& par, const Input& in, const RigidBodyState& body, Real h, const State& x,
                   Limited& limited) noexcept {
    Pull d = begin_pull(par, x, in.engaged, in.valid, h, limited);
    d.from = d.to = d.fresh ? Target{.X_WD = body.X_WB, .V_WD = {}} : x.last;
    if (in.valid) d.F_1_WB = {.tau = d.ramp.s * in.F_WB.tau, .f = d.ramp.s * in.F_WB.f};
    d.F_0_WB = d.fresh ? d.F_1_WB : x.F_WB;
    return d;
  }
};

/// The device moved on for a time dt while no step was taken: what the host has missed is a gap in the samples.
inline void pass_time(DeviceState& x, Real dt, Real h) noexcept {
  if (x.held + dt <= (bridged_steps + Real(0.5)) * h) x.last = carried_on(x.last, dt);
  x.held += dt;
}

}  // namespace godobject
