// Tools with heavy ends, released: energy gains and joint violations. A gain is measured against the largest
// kinetic energy so far.
#pragma once

#include <memory>

#include "tests/core/joint/random_tool.h"

namespace godobject {

struct Swung {
  Real gain = 0;   // of the most kinetic energy
  Real drift = 0;  // m
  bool fault = false;
};

/// Lets the tool go where it stands; targets do not pull. Ends at a fault.
template <Scene S>
Swung swing(Running<S>& run, int steps) {
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
    engage_at<S>(run.x, i, {.X_WD = run.x.bodies[i].x.X_WB, .V_WD = {}});
    run.in.devices[i].target.X_WD = run.x.bodies[i].x.X_WB;
  }
  const Real first = energy(run.par, run.x);
  Real moving = kinetic_energy(run.par, run.x);
  Swung worst;
  for (int n = 0; n < steps; ++n) {
    run.step();
    worst.fault = any(run.out.fault);
    if (worst.fault) break;
    moving = std::max(moving, kinetic_energy(run.par, run.x));
    worst.gain = std::max(worst.gain, (energy(run.par, run.x) - first) / std::max(moving, 1e-9));
    worst.drift = std::max(worst.drift, drift(run.par, run.x).m);
  }
  return worst;
}

/// Swings the chains of the issue: links of 50 g on ball joints, the last one `ratio` times heavier, released
/// at an angle from the vertical.
template <class I>
Swung released_chain(std::size_t links, Real ratio, Real angle, Real h = 1e-3, int steps = 20000) {
  using S = Articulated<I>;
  const auto run = std::make_unique<Running<S>>();
  run->par.h = h;
  run->par.num_bodies = links;
  run->par.gravity_W = Vec3(0, 0, -9.81);
  const Quat q = exp_so3(Vec3(0, angle, 0));
  const Vec3 down = q * Vec3(0, 0, -1);
  for (std::size_t i = 0; i < links; ++i) {
    const Real share = i + 1 == links ? ratio : 1;
    BodyParams<S>& b = run->par.bodies[i];
    b.body = rigid_body(share * 0.05, share * Vec3(4.2083e-5, 4.2083e-5, 8.3333e-7).asDiagonal());
    b.joint.kind = JointKind::ball;
    b.joint.parent = i == 0 ? world : i - 1;
    b.joint.P.p = i == 0 ? Vec3(0, 0, 0) : Vec3(0, 0, -0.05);
    b.joint.C.p = Vec3(0, 0, 0.05);
    const Real depth = (static_cast<Real>(i) + 0.5) * 0.1;
    place<S>(run->x, i, {.X_WB = {.p = depth * down, .q = q}, .V_WB = {}});
  }
  return swing(*run, steps);
}

}  // namespace godobject
