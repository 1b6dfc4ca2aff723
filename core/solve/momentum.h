// Momentum of bodies in a stage with terms and joints.
//
// A closing joint (62) is stiff: K_rigid times the rounding of V is up to 1e-8 of the largest force. Joints
// to the world carry the impulse of this rounding. A tool in flight is moved by it: the change of its
// momentum is then the reported forces.
#pragma once

#include "core/solve/island_terms.h"
#include "core/solve/pairs.h"

namespace godobject {

/// Sets F = w.x.Ap, the impulse of each body's motion beyond its contacts, terms and nets. Bodies outside of
/// islands have none.
template <class Contacts, std::size_t N>
void set_missing_impulses(std::size_t num_bodies, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& F = w.x.Ap;
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    F[i] = SpatialVector::zero();
    if (!is_in_island(i, w)) continue;
    const Wrench& on_contacts = w.wrenches[i];
    F[i] = times(w.stages[i], w.x.V[i]) -
           (w.stages[i].b + SpatialVector{.w = Column(on_contacts.tau), .v = Column(on_contacts.f)} * h);
  }
  each_term_impulse(w, [&](std::uint32_t u, const SpatialVector& J) noexcept { F[u] = F[u] - J; });
  if constexpr (Contacts::has_net)
    each_net_impulse(w, [&](std::uint32_t i, const SpatialVector& J) noexcept { F[i] = F[i] - J; });
}

/// Moves tools that no joint holds by their missing impulses, at equal velocity of all bodies of a tool.
/// F: those impulses, set by set_missing_impulses().
template <class Contacts, std::size_t N>
void balance_flight(std::size_t num_bodies, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& F = w.x.Ap;
  std::array<Column, N> J, dv;
  std::array<Real, N> M;
  for (std::size_t i = 0; i < num_bodies; ++i) J[i] = F[i].v, M[i] = w.stages[i].M;
  const auto edge_of = [&]([[maybe_unused]] std::size_t i) noexcept -> decltype(auto) {
    if constexpr (Contacts::jointed) return (w.graph.joints.edges[i]);
    else return JointEdge{};
  };
  for (std::size_t i = num_bodies; i-- > 0;) {  // children before parents
    const JointEdge& edge = edge_of(i);
    if (!edge.on_body()) continue;
    J[edge.parent] += J[i];
    M[edge.parent] += M[i];
  }
  for (std::size_t i = 0; i < num_bodies; ++i) {
    const JointEdge& edge = edge_of(i);
    if (edge.on_body()) dv[i] = dv[edge.parent];
    else dv[i] = edge.on_world() ? Column(Pack(0)) : J[i] * (-1 / M[i]);
    w.x.V[i].v += dv[i];
    F[i].v += dv[i] * w.stages[i].M;
  }
}

}  // namespace godobject
