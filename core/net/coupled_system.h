// Bodies and the nodes of nets as one system A V = b: what conjugate gradients ask of it.
//
// The matrix of the nodes is never stored: anchors, springs and contacts of nodes multiply by the few numbers that they
// are. Bodies, with their joints, are a block system. The preconditioner has two levels: the nodes by themselves (43),
// and the bodies with all their nodes riding on them rigidly,
//
//   (44)  M^-1 = P (43)^-1 P^T + Z E^-1 Z^T,  Z: v_n = v_b + w_b x r,  E = Z^T A Z,  P: of the nodes
//
// E is exact, joints included, so a net on its carrier falls, turns and hits as one from the first iteration on. Where the
// iteration ends, V is taken to where the balance of energy (28) and the momenta of the whole hold, whatever is left of
// its deformation:
//
//   (45)  V+ = s V + Z c  with  V+^T r = 0,  Z^T r = 0
#pragma once

#include "core/net/incomplete_factor.h"
#include "core/system/conjugate_gradients.h"

namespace godobject {

/// Of bodies and nodes.
template <class OfBodies, std::size_t max_nodes>
struct CoupledVector {
  OfBodies bodies;
  std::array<Column, max_nodes> nodes;

  SpatialVector& operator[](std::uint32_t u) noexcept { return bodies[u]; }
  const SpatialVector& operator[](std::uint32_t u) const noexcept { return bodies[u]; }
  Column& operator[](NetNodeNumber u) noexcept { return nodes[u.n]; }
  const Column& operator[](NetNodeNumber u) const noexcept { return nodes[u.n]; }
};
/// f(run) of the nodes that bodies carry.
template <class Net, std::size_t N, class F>
void each_carried(const NetStage<Net, N>& w, F f) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k)
    if (w.runs[k].body != world) f(w.runs[k]);
}

/// The system of bodies `bodies` and the nets that they carry and touch.
template <class OfBodies, class Stage>
struct CoupledSystem {
  using Vector = CoupledVector<typename OfBodies::Vector, Stage::max_nodes>;
  OfBodies& bodies;
  Stage& net;
  Vector& b;

  /// f(number) of all unknowns.
  template <class F>
  void each(F f) const noexcept {
    bodies.each(f);
    for (std::uint32_t n = 0; n < net.num_nodes; ++n) f(NetNodeNumber{n});
  }
  const BlockJoint* joint_of(std::uint32_t u) const noexcept { return bodies.joint_of(u); }
  static const BlockJoint* joint_of(NetNodeNumber) noexcept { return nullptr; }

  /// AV = A V.
  void multiply(const Vector& V, Vector& AV) const noexcept {
    bodies.multiply(V.bodies, AV.bodies);
    multiply_anchors(V, AV);
    each_spring(net, [&](std::uint32_t i, std::uint32_t j, std::uint32_t s) noexcept {
      const Column J = spring_product(net.q_a[s], V.nodes[j] - V.nodes[i]);
      AV.nodes[j] += J;
      AV.nodes[i] -= J;
    });
    for (std::size_t c = 0; c < net.num_contacts; ++c) {
      const NetContactImpedance& contact = net.contacts[c];
      Column v = V.nodes[contact.node];
      const bool on_body = contact.body != NetContactImpedance::on_world;
      if (on_body) v -= shifted(V.bodies[contact.body], contact.r).v;
      const Column J = v * contact.a + contact.n * (contact.b * dot(contact.n, v));
      AV.nodes[contact.node] += J;
      if (on_body)
        AV.bodies[contact.body] = AV.bodies[contact.body] - moved_wrench({.w = Column(Pack(0)), .v = J}, contact.r);
    }
  }

  /// Z^T F: what acts on the bodies if their nodes ride on them.
  void gather(const Vector& F, typename OfBodies::Vector& on_bodies) const noexcept {
    bodies.each([&](std::uint32_t u) noexcept { on_bodies[u] = F.bodies[u]; });
    each_carried(net, [&](const NetRun& run) noexcept {
      SpatialVector& sum = on_bodies[run.body];
      for (std::uint32_t n = run.first; n < run.end; ++n)
        sum = sum + moved_wrench({.w = Column(Pack(0)), .v = F.nodes[n]}, net.r[n]);
    });
  }
  /// V += Z c.
  void add_riding(const typename OfBodies::Vector& c, Vector& V) const noexcept {
    bodies.each([&](std::uint32_t u) noexcept { V.bodies[u] = V.bodies[u] + c[u]; });
    each_carried(net, [&](const NetRun& run) noexcept {
      const SpatialVector& c_b = c[run.body];
      for (std::uint32_t n = run.first; n < run.end; ++n) V.nodes[n] += shifted(c_b, net.r[n]).v;
    });
  }

 private:
  /// Masses and anchors of the nodes.
  void multiply_anchors(const Vector& V, Vector& AV) const noexcept {
    for (std::size_t k = 0; k < net.num_runs; ++k) {
      const NetRun& run = net.runs[k];
      if (run.body == world) {
        for (std::uint32_t n = run.first; n < run.end; ++n) AV.nodes[n] = V.nodes[n] * (net.m[n] + net.kappa[n]);
        continue;
      }
      const SpatialVector V_b = V.bodies[run.body];
      SpatialVector on_carrier = SpatialVector::zero();
      for (std::uint32_t n = run.first; n < run.end; ++n) {
        const Column J = (V.nodes[n] - shifted(V_b, net.r[n]).v) * net.kappa[n];
        AV.nodes[n] = V.nodes[n] * net.m[n] + J;
        on_carrier = on_carrier + moved_wrench({.w = Column(Pack(0)), .v = J}, net.r[n]);
      }
      AV.bodies[run.body] = AV.bodies[run.body] - on_carrier;
    }
  }
};

/// (44)  z = M^-1 r. r is used up.
template <class OfBodies, class Stage>
void solve(const CoupledSystem<OfBodies, Stage>& system, typename CoupledSystem<OfBodies, Stage>::Vector& r,
           typename CoupledSystem<OfBodies, Stage>::Vector& z) noexcept {
  auto& on_bodies = system.net.riding;
  system.gather(r, on_bodies);
  solve(system.bodies, on_bodies, z.bodies);
  solve_nodes(system.net, r.nodes, z.nodes);
  each_carried(system.net, [&](const NetRun& run) noexcept {
    const SpatialVector& z_b = z.bodies[run.body];
    for (std::uint32_t n = run.first; n < run.end; ++n) z.nodes[n] += shifted(z_b, system.net.r[n]).v;
  });
}

/// (45)  V where r is orthogonal to it and to all rigid motions of bodies with their nodes. p and Ap are used up.
template <class OfBodies, class Stage, class Vectors>
void keep_balance(const CoupledSystem<OfBodies, Stage>& system, Vectors& x) noexcept {
  auto &riding = system.net.riding, &delta = system.net.delta, &c_1 = system.net.c_1, &AV = system.net.riding_AV;
  const auto& b = system.b;
  // delta = E^-1 Z^T r,  c_1 = E^-1 Z^T A V
  system.gather(x.r, riding);
  solve(system.bodies, riding, delta);
  system.each([&](auto u) noexcept { x.Ap[u] = b[u] - x.r[u]; });
  system.gather(x.Ap, AV);
  riding = AV;
  solve(system.bodies, riding, c_1);
  // s - 1 = (V^T r - (Z^T A V)^T delta) / (V^T A V - (Z^T A V)^T c_1)
  SpatialSum V_r, V_A_V;
  system.each([&](auto u) noexcept {
    V_r.add(x.V[u], x.r[u]);
    V_A_V.add(x.V[u], x.Ap[u]);
  });
  SpatialSum along_delta, along_c_1;
  system.bodies.each([&](std::uint32_t u) noexcept {
    along_delta.add(AV[u], delta[u]);
    along_c_1.add(AV[u], c_1[u]);
  });
  const Real deforming = V_A_V - along_c_1;
  const Real s_1 = deforming > 1e-12 * V_A_V ? (V_r - along_delta) / deforming : 0;
  // V+ = V + Z delta + (s - 1) (V - Z c_1)
  system.each([&](auto u) noexcept { x.p[u] = x.V[u] * s_1; });
  system.bodies.each([&](std::uint32_t u) noexcept { delta[u] = delta[u] - c_1[u] * s_1; });
  system.add_riding(delta, x.p);
  system.multiply(x.p, x.Ap);
  system.each([&](auto u) noexcept {
    x.V[u] = x.V[u] + x.p[u];
    x.r[u] = x.r[u] - x.Ap[u];
  });
}

}  // namespace godobject
