// Prescribed joints: g(x, t) = 0, the coordinates follow the device instead of the forces (the jaws of
// the paper).
#pragma once

#include "core/device/device.h"
#include "core/joint/turns.h"

namespace godobject {

/// Coordinates of a prescribed joint and their rates.
struct JointMotionSample {
  JointCoordinates q = JointCoordinates::Zero();
  JointCoordinates q_dot = JointCoordinates::Zero();
};

/// Prescribed part of the joints. The force that the motion needs is in the reaction F_C.
struct PrescribedJoints {
  struct Params {
    bool prescribed = false;
  };
  struct State {
    JointMotionSample last;  // prescribed coordinates of the previous step
  };
  using Input = JointMotionSample;  // at the END of the step; turns of any count
};

/// Prescribed motion of a joint during one step.
struct PrescribedMotion {
  JointMotionSample from, to;
};

/// Returns the prescribed coordinates for this step: the device's while engaged, blended in during the ramp,
/// so that engaging moves nothing at once. Constant while disengaged and after more than bridged_steps
/// missing samples.
inline PrescribedMotion prescribe(const PrescribedJoints::State& x, int turns, const JointMotionSample& in,
                                  const RampState& before, const CouplingInput& input, Real h) noexcept {
  PrescribedMotion l{.from = x.last, .to = {.q = x.last.q, .q_dot = JointCoordinates::Zero()}};
  if (!input.ramp.engaged || !input.live) {
    if (input.ramp.engaged && input.gap.bridged)
      l.to = {.q = x.last.q + h * x.last.q_dot, .q_dot = x.last.q_dot};
    return l;
  }
  const JointCoordinates q = unwrapped(in.q, x.last.q, turns);  // nearest turn
  const Real s_0 = input.fresh ? 0 : before.s, s = input.ramp.s;
  if (s_0 >= 1 || s >= 1) {
    l.to = {.q = q, .q_dot = in.q_dot};
  } else {
    l.to.q += (q - l.from.q) * ((s - s_0) / (1 - s_0));
    l.to.q_dot = (l.to.q - l.from.q) * (1 / h);
  }
  return l;
}

/// Interpolates the coordinates at the fraction s of a step of length h: the cubic through both ends and
/// their rates, as (15).
inline JointCoordinates interpolated(const PrescribedMotion& l, Real s, Real h) noexcept {
  const Real r = 1 - s;
  return r * r * (1 + 2 * s) * l.from.q + s * s * (1 + 2 * r) * l.to.q + h * s * r * r * l.from.q_dot -
         h * s * s * r * l.to.q_dot;
}

}  // namespace godobject
