// Imposed joints: g(x, t) = 0, the coordinates follow the device instead of the forces (the paper's imposed jaws).
#pragma once

#include "core/device/device.h"
#include "core/joint/joint.h"

namespace godobject {

/// Coordinates of an imposed joint and their rates.
struct JointMotionSample {
  JointCoordinates q = JointCoordinates::Zero();
  JointCoordinates q_dot = JointCoordinates::Zero();
};

/// The imposed part of the joints. What the joint needs is in the reaction F_C.
struct ImposedJoints {
  struct Params {
    bool imposed = false;
  };
  struct State {
    JointMotionSample last;  // where the coordinates were led in the last step
  };
  using Input = JointMotionSample;  // at the END of the step; turns within [-pi, pi]
};

/// Where a joint is led during one step.
struct Lead {
  JointMotionSample from, to;
};

/// q within half a turn of `near`, for the coordinates that are turns: the same attitude. Three turns have none.
inline JointCoordinates unwrapped(JointCoordinates q, const JointCoordinates& near, int turns) noexcept {
  for (int c = 0; turns < 3 && c < turns; ++c) {
    const Real off = q[c] - near[c];
    q[c] -= off > pi ? 2 * pi : off < -pi ? -2 * pi : 0;
  }
  return q;
}

/// Towards the device's coordinates while it is engaged; during its ramp by the share that ends on them with the
/// ramp, so that engaging moves nothing at once. Let go, or after the bridge over missing samples, the joint rests.
inline Lead lead(const ImposedJoints::State& x, int turns, const JointMotionSample& in,
                 const RampState& before, const Pull& pull, Real h) noexcept {
  Lead l{.from = x.last, .to = {.q = x.last.q, .q_dot = JointCoordinates::Zero()}};
  if (!pull.ramp.engaged || !pull.live) {
    const JointCoordinates q = x.last.q + h * x.last.q_dot;
    const bool in_turn = unwrapped(q, JointCoordinates::Zero(), turns) == q;
    if (pull.ramp.engaged && pull.gap.bridged && in_turn) l.to = {.q = q, .q_dot = x.last.q_dot};
    return l;
  }
  l.from.q = l.to.q = unwrapped(x.last.q, in.q, turns);  // the short way round
  const Real s_0 = pull.fresh ? 0 : before.s, s = pull.ramp.s;
  if (s_0 >= 1 || s >= 1) {
    l.to = in;
  } else {
    l.to.q += (in.q - l.from.q) * ((s - s_0) / (1 - s_0));
    l.to.q_dot = (l.to.q - l.from.q) * (1 / h);
  }
  return l;
}

/// Coordinates at the fraction s of a step of length h: the cubic through both ends and their rates, as (15).
inline JointCoordinates interpolated(const Lead& l, Real s, Real h) noexcept {
  const Real r = 1 - s;
  return r * r * (1 + 2 * s) * l.from.q + s * s * (1 + 2 * r) * l.to.q + h * s * r * r * l.from.q_dot -
         h * s * s * r * l.to.q_dot;
}

}  // namespace godobject
