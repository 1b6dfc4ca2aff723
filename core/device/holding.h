// Device that grips a body at its current pose and releases it, at any time.
#pragma once

#include "core/body/rigid_body.h"
#include "core/device/device.h"
#include "core/math/pose.h"

namespace godobject {

/// Returns X_AB = X_WA^-1 X_WB, the pose of B in A.
inline Pose seen_from(const Pose& X_WA, const Pose& X_WB) noexcept {
  const Quat q_AW = X_WA.q.conjugate();
  return {.p = to_world(q_AW, X_WB.p - X_WA.p), .q = renormalized(q_AW * X_WB.q)};
}

/// Coupling input with the grip, which is kept between steps.
struct GripInput : CouplingInput {
  Pose X_DB;  // pose of the gripped body in the device's frame
};

struct HoldingState : DeviceState {
  Pose X_DB;
};

inline HoldingState state_after(const GripInput& input) noexcept {
  return {state_after(static_cast<const CouplingInput&>(input)), input.X_DB};
}

/// Device with absolute poses, like PoseDevice, that keeps the gripped body's pose relative to the device at
/// gripping. In the step in which `engaged` rises, the body moves as if free and
///
///   (20)  X_DB = X_WD^-1 X_WB  is taken at the end of that step; from then on the target is
///         X_WD X_DB, which moves with w_D and v_D + w_D x R_WD p_DB.
///
/// The initial pose error is therefore zero for any motion of the two. The damping of their relative velocity
/// rises with the ramp (14). After a gap longer than max_gap_with_grip the body is gripped again at its
/// current pose. While `engaged` is false, the target is the device's pose.
///
/// One device may grip any of several bodies: all of them get its sample, and `engaged` is true for the
/// gripped one.
struct HoldingDevice {
  using Params = RampParams;
  using Input = PoseDevice::Input;
  using CouplingInput = GripInput;
  using State = HoldingState;

  static CouplingInput coupling_input(const Params& par, const Input& in, const RigidBodyState& body, Real h,
                                      const State& x, Limited& limited) noexcept {
    CouplingInput d{begin_coupling_input(par, x, in.engaged, in.valid, h, limited), {}};
    const Pose X_WD{.p = in.target.X_WD.p, .q = renormalized(in.target.X_WD.q)};
    const bool takes = d.fresh && !(x.held > 0 && is_grip_kept(x));
    if (d.ramp.engaged) d.X_DB = takes ? seen_from(X_WD, moved(body.X_WB, body.v_W, body.w_B, h)) : x.X_DB;
    d.from = x.last;
    d.to = {.X_WD = x.last.X_WD, .V_WD = {}};
    if (in.valid) d.to = held(X_WD, in.target.V_WD, d.X_DB);
    else if (d.gap.bridged) d.to = extrapolated_target(x.last, h);
    if (d.fresh) d.from = d.to;
    d.to.X_WD.q = same_sign(d.to.X_WD.q, d.from.X_WD.q);
    return d;
  }

 private:
  /// Returns the target of a gripped body (20).
  static Target held(const Pose& X_WD, const Twist& V_WD, const Pose& X_DB) noexcept {
    const Vec3 p_DB_W = to_world(X_WD.q, X_DB.p);
    return {.X_WD = X_WD * X_DB, .V_WD = {.w = V_WD.w, .v = V_WD.v + V_WD.w.cross(p_DB_W)}};
  }
};

}  // namespace godobject
