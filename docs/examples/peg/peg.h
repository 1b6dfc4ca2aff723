// README's Peg: one rigid tool that follows a pose and shows a force.
#pragma once

#include "core/godobject.h"
using namespace godobject;

struct Peg {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;  // None: not haptic, and not there
};
static_assert(Scene<Peg>);

Params<Peg> par;  // constants
State<Peg> x;     // all that carries over
Scratch<Peg> w;   // undefined between steps
Input<Peg> in;    // the device's sample at the end of the step
Output<Peg> out;  // shown wrench, fault and limit bits

bool set_up(const Pose& start) {
  par.h = 1e-3;
  par.num_bodies = 1;
  par.bodies[0].body = rigid_body(0.1, Vec3(3.5e-4, 3.5e-4, 2.7e-5).asDiagonal());
  par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.026};
  par.bodies[0].feedback.gains = par.bodies[0].coupling;
  place(x, 0, {.X_WB = start, .V_WB = {}});
  return validate(par) == Invalid::nothing;
}
