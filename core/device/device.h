// Devices: their inputs per step and the targets of bodies derived from them. PoseDevice serves impedance and
// non-haptic devices, with and without feedback. Gaps in the samples are bridged, held and faded here.
#pragma once

#include <algorithm>

#include "core/body/rigid_body.h"
#include "core/body/target.h"
#include "core/fault.h"
#include "core/tuning.h"

namespace godobject {

struct RampParams {
  Real rise = 0.5;  // s from engaging to full coupling; 0: at once
  Real lost = 0;    // s (and at least bridged_steps) without a valid sample after which the device re-engages
                    // by the ramp
  Real stale = 0;   // s (and at least bridged_steps) for which the displayed wrench stays constant; then it
                    // fades
};

/// Part of the feedback that is displayed in a step.
enum class Showing : std::uint8_t {
  all,
  capped,  // after a gap: the wrench at its end, and the share CouplingInput::growth of the bounds
  still,   // no valid sample: the previous wrench
  fading,  // no valid sample for longer than `stale`: fading to zero
};

struct RampState {
  Real s = 0;  // ramp of the last step
  bool engaged = false;
};

/// Effect of a gap in the samples on a step without a valid sample and on those after it.
struct Gap {
  Real held = 0;      // s since the last valid sample
  Real recovery = 0;  // s until the full feedback may be displayed
  Real growth = 0;    // see Showing::capped
  Showing showing = Showing::all;
  bool long_gap = false;   // true if `recovery` follows a long gap: the feedback grows meanwhile
  bool bridged = false;    // true if the target is extrapolated; without a sample and not bridged it rests
  bool back = false;       // first valid sample after a gap
  bool reengages = false;  // the gap exceeded `lost`: the device re-engages by the ramp
};

/// Coupling input of one body in one step: the target at both ends, and the ramp.
struct CouplingInput {
  Target from, to;        // target at the start and the end of the step, quaternions of one sign
  RampState ramp;         // during this step
  Wrench F_WB;            // wrench applied by the hand (admittance) at the end of a stage
  Wrench F_0_WB, F_1_WB;  // wrenches at the start and the end of the step
  bool live = true;       // true if the step has a valid sample
  bool fresh = false;     // first step after engaging or releasing: no history is valid
  Gap gap;
};

/// State common to all devices.
struct DeviceState {
  Target last;  // target of the last step
  RampState ramp;
  Real held = 0;          // s since the last valid sample
  Real recovery = 0;      // s until the full feedback may be displayed after a gap
  bool long_gap = false;  // true if that gap was long: the feedback grows meanwhile
  Wrench F_WB;            // wrench at the end of the last step, of an admittance device
};

/// Returns the state after the step.
inline DeviceState state_after(const CouplingInput& input) noexcept {
  return {.last = input.to,
          .ramp = input.ramp,
          .held = input.gap.held,
          .recovery = input.gap.recovery,
          .long_gap = input.gap.long_gap,
          .F_WB = input.F_1_WB};
}

/// Return type of a device part's coupling_input(): CouplingInput, or a type derived from it of that name.
template <class Device>
struct CouplingInputOf {
  using type = CouplingInput;
};
template <class Device>
requires requires { typename Device::CouplingInput; }
struct CouplingInputOf<Device> {
  using type = typename Device::CouplingInput;
};

/// Returns a pose displaced by dp and dphi. |dphi| is limited to pi, because faster rotation is aliased by
/// the sampling.
inline Pose displaced(const Pose& X, const Vec3& dp_W, const Vec3& dphi_W) noexcept {
  return {.p = X.p + dp_W, .q = renormalized(exp_so3(at_most_half_a_turn(dphi_W)) * X.q)};
}
/// Extrapolates a target by its velocity over a time dt, s.
inline Target extrapolated_target(const Target& x, Real dt) noexcept {
  return {.X_WD = displaced(x.X_WD, dt * x.V_WD.v, dt * x.V_WD.w), .V_WD = x.V_WD};
}

/// Returns the gap of a step without a valid sample, or of a step after one. Short gaps are bridged. During
/// longer ones the target rests and the displayed wrench fades. Afterwards the device re-engages by the ramp,
/// because the hand may have moved anywhere. The feedback does not grow until the body has caught up, so no
/// gap displays more than before it.
[[gnu::noinline]] inline Gap bridge(const RampParams& par, const DeviceState& x, bool valid,
                                    Real h) noexcept {
  const auto longer_than = [h](Real held, Real s) { return held > std::max(s, bridged_steps * h) + h / 2; };
  Gap gap;
  gap.recovery = std::max(x.recovery - h, Real(0));
  gap.long_gap = x.long_gap && gap.recovery > 0;
  if (!valid) {
    gap.held = x.held + h;
    gap.bridged = !longer_than(gap.held, 0);
    gap.showing = longer_than(gap.held, par.stale) ? Showing::fading : Showing::still;
    return gap;
  }
  if (x.held > 0 && longer_than(x.held, par.lost)) {
    gap.reengages = gap.long_gap = gap.back = true;
    gap.recovery = std::max(par.rise, after_gap) + after_gap;
  } else if (x.held > 0 && x.recovery == 0) {
    gap.recovery = recovery_per_gap * x.held;
    gap.back = true;
  }
  if (gap.recovery == 0) return gap;
  const Real grown = gap.long_gap ? std::max(1 - gap.recovery / after_gap, Real(0)) : 0;
  gap.showing = Showing::capped;
  gap.growth = grown * grown;
  return gap;
}

/// Begins the coupling input of a step. The ramp is 0 in the first engaged step, so that engaging moves
/// nothing, and then rises linearly to 1. Engaging, also after a gap too long to be bridged, requires a valid
/// sample.
inline CouplingInput begin_coupling_input(const RampParams& par, const DeviceState& x, bool wanted,
                                          bool valid, Real h, Limited& limited) noexcept {
  RampState before = x.ramp;
  CouplingInput input;
  input.live = valid;
  if (!valid || x.held > 0 || x.recovery > 0) [[unlikely]] {
    input.gap = bridge(par, x, valid, h);
    if (input.gap.reengages) before = {};
    if (!valid) limited |= Limited::held;
    if (input.gap.showing == Showing::capped) limited |= Limited::ramp;
  }
  const bool engage = wanted && (valid || before.engaged);
  input.fresh = engage != before.engaged || engage != x.ramp.engaged;
  input.ramp.engaged = engage;
  if (!engage) return input;
  if (before.s == 1 || par.rise <= h) {
    input.ramp.s = 1;
  } else {
    input.ramp.s = input.fresh ? 0 : std::min(Real(1), before.s + h / par.rise);
    limited |= Limited::ramp;
  }
  return input;
}

/// True if a grip survives the gap: engaged before it, and the gap is at most max_gap_with_grip.
inline bool is_grip_kept(const DeviceState& x) noexcept {
  return x.ramp.engaged && x.held <= max_gap_with_grip;
}

/// Returns q or -q, the same attitude: the one nearer to `reference`.
inline Quat same_sign(const Quat& q, const Quat& reference) noexcept {
  return q.dot(reference) < 0 ? Quat(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

/// Device with absolute poses: impedance devices, trackers.
struct PoseDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Target target;
    bool valid = true;    // true if this step has a sample; otherwise the target rests at the last one
    bool engaged = true;  // true if the device drives its body
  };

  static CouplingInput coupling_input(const Params& par, const Input& in, const RigidBodyState&, Real h,
                                      const State& x, Limited& limited) noexcept {
    CouplingInput d = begin_coupling_input(par, x, in.engaged, in.valid, h, limited);
    d.from = x.last;
    d.to = {.X_WD = x.last.X_WD, .V_WD = {}};
    if (in.valid)
      d.to = {.X_WD = {.p = in.target.X_WD.p, .q = renormalized(in.target.X_WD.q)}, .V_WD = in.target.V_WD};
    else if (d.gap.bridged) d.to = extrapolated_target(x.last, h);
    if (d.fresh) d.from = d.to;
    d.to.X_WD.q = same_sign(d.to.X_WD.q, d.from.X_WD.q);
    return d;
  }
};

/// Device with increments of pose and a clutch: a mouse, or an arm whose workspace is too small.
struct RelativeDevice {
  struct Params : RampParams {
    Real display_ratio = 1;  // shift of the target for a shift of the device; below 1 the tool seems heavier
  };
  using State = DeviceState;
  struct Input {
    Vec3 dp_W = Vec3::Zero();    // shift since the last sample, m
    Vec3 dphi_W = Vec3::Zero();  // rotation since the last sample, rad, |dphi| <= pi
    bool clutch = true;          // true if motion of the device moves the target
    bool valid = true;
    bool engaged = true;
  };

  static CouplingInput coupling_input(const Params& par, const Input& in, const RigidBodyState& body, Real h,
                                      const State& x, Limited& limited) noexcept {
    CouplingInput d = begin_coupling_input(par, x, in.engaged, in.valid, h, limited);
    const bool gap_ends = in.valid && x.held > 0 && is_grip_kept(x);
    d.from = d.fresh && !gap_ends ? Target{.X_WD = body.X_WB, .V_WD = {}} : x.last;
    d.to.X_WD = d.from.X_WD;
    if (gap_ends) {
      d.to = after_gap(par, in, x, h);
      if (d.fresh) d.from = d.to;
    } else if (in.clutch && in.valid && x.held == 0) {
      const Vec3 dp_W = par.display_ratio * in.dp_W;
      d.to.X_WD = displaced(d.from.X_WD, dp_W, in.dphi_W);
      d.to.V_WD = {.w = in.dphi_W / h, .v = dp_W / h};
    } else if (!in.valid && d.gap.bridged && !d.fresh) {
      d.to = extrapolated_target(x.last, h);
    }
    return d;
  }

 private:
  /// Returns the target after a gap. The increments cover the whole gap; the part that the bridge
  /// extrapolated is subtracted if the target still moves. After a gap longer than a grip lasts they are
  /// dropped, and the device engages at the body's place.
  static Target after_gap(const Params& par, const Input& in, const State& x, Real h) noexcept {
    const Real bridged = std::min(x.held, bridged_steps * h), since = x.held + h, open = in.clutch ? 1 : 0;
    const Vec3 shift_W = open * par.display_ratio * in.dp_W;
    const Vec3 dp_W = shift_W - bridged * x.last.V_WD.v, dphi_W = open * in.dphi_W - bridged * x.last.V_WD.w;
    return {.X_WD = displaced(x.last.X_WD, dp_W, dphi_W),
            .V_WD = {.w = (open / since) * in.dphi_W, .v = shift_W / since}};
  }
};

/// Device with forces as inputs and poses as outputs. Its spring, if any, is fixed to the body's place at
/// engaging.
struct AdmittanceDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Wrench F_WB;  // wrench of the hand on the body, about its centre of mass
    bool valid = true;
    bool engaged = true;
  };

  static CouplingInput coupling_input(const Params& par, const Input& in, const RigidBodyState& body, Real h,
                                      const State& x, Limited& limited) noexcept {
    CouplingInput d = begin_coupling_input(par, x, in.engaged, in.valid, h, limited);
    d.from = d.to = d.fresh ? Target{.X_WD = body.X_WB, .V_WD = {}} : x.last;
    if (in.valid) d.F_1_WB = {.tau = d.ramp.s * in.F_WB.tau, .f = d.ramp.s * in.F_WB.f};
    d.F_0_WB = d.fresh ? d.F_1_WB : x.F_WB;
    return d;
  }
};

/// Advances a device by a time dt without steps: the missed periods become a gap in the samples.
inline void pass_time(DeviceState& x, Real dt, Real h) noexcept {
  if (x.held + dt <= (bridged_steps + Real(0.5)) * h) x.last = extrapolated_target(x.last, dt);
  x.held += dt;
}

}  // namespace godobject
