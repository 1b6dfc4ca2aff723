// Trees of joints whose targets contradict them: each body is pulled to where the others do not let it be.
#pragma once

#include <memory>

#include "tests/core/joint/random_tool.h"

namespace godobject {

struct PulledApart {
  Real h, k;         // s, N/m
  Real offset;       // of the targets, by the size of the bodies and in rad
  Real fastest = 0;  // of the bodies in the last tenth, m/s
  Real drift = 0;    // m
  bool fault = false;
};

/// Draws a random tree of 2 to 8 bodies with masses of 10 g to 10 kg, on joints of all kinds, joined and at
/// rest at first. change(drawn): deviation of a study from the drawn case.
template <class I, class Change = void (*)(PulledApart&)>
PulledApart pulled_apart(
    unsigned seed, Change change = [](PulledApart&) {}) {
  using S = Articulated<I>;
  constexpr Real size = 0.1, duration = 4;
  Random random(seed);
  const auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  PulledApart c{.h = random.log_uniform(2e-4, 5e-3),
                .k = random.log_uniform(1e3, 1e10),
                .offset = random.log_uniform(0.03, 3)};
  change(c);
  par.h = c.h;
  par.num_bodies = static_cast<std::size_t>(random.integer(2, 8));
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    add_random_body(par, i, size, random);
    const RigidBodyParams& body = par.bodies[i].body;
    const Real I_m = body.I_B.trace() / 3, k_r = c.k * I_m / body.m;
    par.bodies[i].coupling = {
        .k = c.k, .g = 1.4 * std::sqrt(c.k * body.m), .k_r = k_r, .g_r = 1.4 * std::sqrt(k_r * I_m)};
  }
  place_randomly(par, run->x, size, 0, random);
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    Pose X_WD = run->x.bodies[i].x.X_WB;
    X_WD.p += c.offset * size * random.direction();
    X_WD.q = X_WD.q * exp_so3(Vec3(c.offset * random.direction()));
    engage_at<S>(run->x, i, {.X_WD = X_WD, .V_WD = {}});
    run->in.devices[i].target.X_WD = X_WD;
    run->in.devices[i].engaged = run->in.devices[i].valid = true;
  }
  const int steps = static_cast<int>(duration / par.h);
  for (int n = 0; n < steps && !c.fault; ++n) {
    run->step();
    c.fault = any(run->out.fault);
    if (n < steps - steps / 10) continue;
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      const RigidBodyState& x = run->x.bodies[i].x;
      c.fastest = std::max({c.fastest, x.v_W.norm(), size * x.w_B.norm()});
    }
    c.drift = std::max(c.drift, drift(par, run->x).m);
  }
  return c;
}

}  // namespace godobject
