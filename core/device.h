// How a device drives a body: what it sends each step, and the target that becomes of it.
// Impedance and non-haptic devices are PoseDevice (with and without feedback).
#pragma once

#include <algorithm>

#include "core/fault.h"
#include "core/scene.h"
#include "core/target.h"

namespace godobject {

struct RampParams {
  Real rise = 0.5;   // s from engaging to full coupling; 0: at once
  Real lost = 0.02;  // s (and at least 3 steps) without a valid sample after which the device engages anew
};

struct RampState {
  Real s = 0;  // ramp of the last step
  bool engaged = false;
};

/// What pulls one body during one step: the target at both ends, and how far the ramp is.
struct Pull {
  Target from, to;     // target at the start and the end of the step, quaternions of one sign
  RampState ramp;      // during this step
  Real held = 0;       // s since the last valid sample
  Wrench F_WB;         // force and torque applied by the hand (admittance)
  bool live = true;    // false: no valid sample; the target rests and nothing is shown to the hand
  bool fresh = false;  // first step after engaging or letting go: no history may be used
};

/// What all devices carry over.
struct DeviceState {
  Target last;  // target of the last step
  RampState ramp;
  Real held = 0;  // s since the last valid sample
};

/// The state after the step.
inline DeviceState carried_over(const Pull& pull) noexcept {
  return {.last = pull.to, .ramp = pull.ramp, .held = pull.held};
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

/// The ramp: 0 in the first engaged step, so that engaging moves nothing; then rising linearly to 1. Engaging takes
/// a valid sample, and so does going on after a long time without one.
inline Pull begin_pull(const RampParams& par, const DeviceState& x, bool wanted, bool valid, Real h,
                       Limited& limited) noexcept {
  const RampState before = valid && x.held > std::max(par.lost, 3 * h) ? RampState{} : x.ramp;
  const bool engage = wanted && (valid || before.engaged);
  Pull pull;
  pull.live = valid;
  pull.held = valid ? 0 : x.held + h;
  pull.fresh = engage != before.engaged;
  pull.ramp.engaged = engage;
  if (!valid) limited |= Limited::held;
  if (!engage) return pull;
  if (before.s == 1 || par.rise <= h) {
    pull.ramp.s = 1;
  } else {
    pull.ramp.s = pull.fresh ? 0 : std::min(Real(1), before.s + h / par.rise);
    limited |= Limited::ramp;
  }
  return pull;
}

/// A quaternion and its negative are one attitude: takes the one nearer to `reference`.
inline Quat same_sign(const Quat& q, const Quat& reference) noexcept {
  return q.dot(reference) < 0 ? Quat(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

/// Gives an absolute pose: impedance devices, trackers.
struct PoseDevice {
  using Params = RampParams;
  using State = DeviceState;
  struct Input {
    Pose X_WD;
    Twist V_WD;
    bool valid = true;    // false: no sample this step; the target rests at the last one
    bool engaged = true;  // false: the device drives nothing
  };

  static Pull pull(const Params& par, const Input& in, const RigidBodyState&, Real h, const State& x,
                   Limited& limited) noexcept {
    Pull d = begin_pull(par, x, in.engaged, in.valid, h, limited);
    d.from = x.last;
    d.to = {.X_WD = x.last.X_WD, .V_WD = {}};
    if (in.valid) d.to = {.X_WD = {.p = in.X_WD.p, .q = renormalized(in.X_WD.q)}, .V_WD = in.V_WD};
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
    d.from = d.fresh ? Target{.X_WD = body.X_WB, .V_WD = {}} : x.last;
    d.to.X_WD = d.from.X_WD;
    if (in.clutch && in.valid) {
      d.to.X_WD = {.p = d.from.X_WD.p + in.dp_W, .q = renormalized(exp_so3(in.dphi_W) * d.from.X_WD.q)};
      d.to.V_WD = {.w = in.dphi_W / h, .v = in.dp_W / h};
    }
    return d;
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
    if (in.valid) d.F_WB = {.tau = d.ramp.s * in.F_WB.tau, .f = d.ramp.s * in.F_WB.f};
    return d;
  }
};

}  // namespace godobject
