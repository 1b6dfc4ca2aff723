// Energies of a state, J, for tests, studies and the trace. The step does not need them.
#pragma once

#include "core/body/coupling.h"
#include "core/counted_errors.h"
#include "core/device/device.h"
#include "core/scene.h"
#include "core/term/term.h"

namespace godobject {

/// Returns the kinetic energy of a body, J.
inline Real kinetic_energy(const RigidBodyParams& par, const RigidBodyState& x) noexcept {
  return Real(0.5) * (par.m * x.v_W.squaredNorm() + x.w_B.dot(par.I_B * x.w_B));
}

/// Motions of a state.
template <class S>
struct MotionsOfState {
  const State<S>& x;

  const RigidBodyState& body(std::size_t i) const noexcept { return x.bodies[i].x; }
  const Vec3& net_node(std::size_t n) const noexcept { return x.net.nodes[n].v_W; }
};

/// Computes the kinetic energy of a scene, J. motions: MotionsOfState, or those at another time.
template <Scene S, class Motions>
Real kinetic_energy_of(const Params<S>& par, const Motions& motions) noexcept {
  Real T = 0;
  for (std::size_t i = 0; i < num_bodies(par); ++i) T += kinetic_energy(par.bodies[i].body, motions.body(i));
  if constexpr (uses<NetOf<S>>) {
    Real of_nets = 0;
    for (std::size_t n = 0; n < num_net_nodes(par); ++n)
      of_nets += Real(0.5) * par.net.nodes[n].m * motions.net_node(n).squaredNorm();
    T += of_nets;
  }
  return T;
}

/// Places of a state, for the energy of terms.
template <class S>
struct TermPlaces {
  const State<S>& x;

  /// Returns the position of the point p of u, m.
  Vec3 point(std::uint32_t u, const Vec3& p) const noexcept {
    if (u == TermEnds::on_world) return p;
    const Pose& X = x.bodies[u].x.X_WB;
    return X.p + to_world(X.q, p);
  }
  /// Returns coordinate c of the joint of body i, rad or m.
  Real coordinate(std::uint32_t i, int c) const noexcept { return x.bodies[i].joint.q[c]; }
};

/// State of a body's coupling at the end of the last step.
struct CouplingAt {
  SpringParams spring;  // gains during the ramp
  Wrench F_WB;          // wrench (2)
  Real energy = 0;      // energy in its spring, J
};
/// errors: those of the state, from coupling_errors().
template <Scene S, class Errors>
CouplingAt coupling_at(const Params<S>& par, const State<S>& x, std::size_t i,
                       const Errors& errors) noexcept {
  const BodyState<S>& body = x.bodies[i];
  const Target& target = body.device.last;
  const SpringParams spring = ramped(par.bodies[i].coupling, body.device.ramp.s);
  const Quat& q = body.x.X_WB.q;
  const CouplingError error = errors[i];
  const Vec3 e_W = target.X_WD.p - body.x.X_WB.p;
  return {.spring = spring,
          .F_WB = {.tau = spring.g_r * (target.V_WD.w - to_world(q, body.x.w_B)) +
                          spring.k_r * to_world(q, error.phi_B),
                   .f = spring.g * (target.V_WD.v - body.x.v_W) + spring.k * e_W},
          .energy = Real(0.5) * (spring.k * e_W.squaredNorm() + spring.k_r * error.twice_energy)};
}
template <Scene S>
CouplingAt coupling_at(const Params<S>& par, const State<S>& x, std::size_t i) noexcept {
  return coupling_at(par, x, i, coupling_errors(par, x));
}

}  // namespace godobject
