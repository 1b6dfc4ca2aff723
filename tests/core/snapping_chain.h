// Chains with a heavy end that snap taut: joints do not hold in a stage that is solved in one (39).
#pragma once

#include "core/energy_balance.h"
#include "tests/core/one_body.h"
#include "tests/study/joint/tool.h"

namespace godobject {

inline constexpr Real snapping_link = 0.1;  // length of a link, m

/// Builds a row of links of 50 g on ball joints, the last one 1000 times heavier, at an angle from the
/// vertical. on_world: the row is released from the origin; otherwise it is free, without gravity.
template <Scene S>
void build_snapping_chain(Running<S>& run, std::size_t links, Real angle, bool on_world) {
  auto& par = run.par;
  par.num_bodies = links;
  par.gravity_W = on_world ? Vec3(0, 0, -9.81) : Vec3(Vec3::Zero());
  const Quat q = exp_so3(Vec3(0, angle, 0));
  const Vec3 down = q * Vec3(0, 0, -1);
  for (std::size_t i = 0; i < links; ++i) {
    const Real share = i + 1 == links ? 1000 : 1;
    auto& body = par.bodies[i];
    body.body = rigid_body(share * 0.05, share * Vec3(4.2e-5, 4.2e-5, 8.3e-7).asDiagonal());
    body.joint.kind = i > 0 || on_world ? JointKind::ball : JointKind::free;
    body.joint.parent = i == 0 ? world : i - 1;
    body.joint.P.p = i == 0 ? Vec3(0, 0, 0) : Vec3(0, 0, -snapping_link / 2);
    body.joint.C.p = Vec3(0, 0, snapping_link / 2);
    const Vec3 p_W = (static_cast<Real>(i) + 0.5) * snapping_link * down;
    place<S>(run.x, i, {.X_WB = {.p = p_W, .q = q}, .V_WB = {}});
    run.in.devices[i] = {};
  }
}

/// Result of a chain.
struct Snapped {
  Real drift = 0;  // m, of its joints
  bool gains = false;
};

template <Scene S>
Snapped snap(Running<S>& run, int steps) {
  EnergyBalance<S> balance;
  balance.start(run.par, run.x);
  Snapped worst;
  for (int n = 0; n < steps; ++n) {
    run.step();
    EXPECT_EQ(run.out.fault, Fault::none) << "step " << n;
    balance.observe(run.par, run.x, run.w, run.out);
    worst.drift = std::max(worst.drift, drift(run.par, run.x).m);
    worst.gains = worst.gains || balance.gains();
  }
  return worst;
}

}  // namespace godobject
