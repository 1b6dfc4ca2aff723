// Energies of nets, J, for tests, studies and the energy balance. The step does not need them.
#pragma once

#include "core/energy.h"
#include "core/scene.h"

namespace godobject {

/// Returns the kinetic energy of the nodes, J.
template <Scene S>
Real net_kinetic_energy(const Params<S>& par, const State<S>& x) noexcept {
  Real T = 0;
  for (std::size_t n = 0; n < par.net.num_nodes; ++n)
    T += Real(0.5) * par.net.nodes[n].m * x.net.nodes[n].v_W.squaredNorm();
  return T;
}

/// Returns sum m p of the nodes, kg m.
template <Scene S>
Vec3 net_mass_moment(const Params<S>& par, const State<S>& x) noexcept {
  Vec3 mp_W = Vec3::Zero();
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) mp_W += par.net.nodes[n].m * x.net.nodes[n].p_W;
  return mp_W;
}

/// Returns the energy in springs, anchors and attachments (41), (42), (49), J.
template <Scene S>
Real net_spring_energy(const Params<S>& par, const State<S>& x) noexcept {
  Real U = 0;
  const auto point = [&](std::size_t body, const Vec3& p_B) noexcept -> Vec3 {
    if (body == world) return p_B;
    const Pose& X_WB = x.bodies[body].x.X_WB;
    return X_WB.p + to_world(X_WB.q, p_B);
  };
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    const NetNode& node = par.net.nodes[n];
    U += Real(0.5) * node.k * (x.net.nodes[n].p_W - point(node.body, node.p_B)).squaredNorm();
  }
  for (const NetAttachment& one : par.net.attachments)
    U += Real(0.5) * one.k * (x.net.nodes[one.node].p_W - point(one.body, one.p_B)).squaredNorm();
  for (std::size_t s = 0; s < par.net.num_springs; ++s) {
    const NetSpring& spring = par.net.springs[s];
    const Real d = (x.net.nodes[spring.j].p_W - x.net.nodes[spring.i].p_W).norm() - spring.l_0;
    U += Real(0.5) * spring.k * d * d;
  }
  return U;
}

}  // namespace godobject
