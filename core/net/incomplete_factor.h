// Incomplete factor of the nodes of nets, the preconditioner of their conjugate gradients.
//
//   (43)  M = (D + L) D^-1 (D + L^T),  L couplings by springs, below the diagonal;
//         D_j = A_jj - sum_{i < j} K_ij D_i^-1 K_ij
//
// Only the diagonal is changed by the factorisation (Meijerink and van der Vorst 1977). Every D is positive
// definite. If D_i >= sum of the K_il, l > i, then K_ij D_i^-1 K_ij <= K_ij. A_jj is the sum of all K at j
// and the mass, so the remainder is D_j >= sum of the K_jl, l > j, plus the mass. i < j is the order of the
// groups of NetParams, whose four nodes are processed at once.
#pragma once

#include "core/net/contact_terms.h"
#include "core/net/settling.h"

namespace godobject {

/// Computes A += K.
inline void add(const SlotMass& K, SymmetricPack& A) noexcept {
  const auto& [u, a, b] = K;
  const Vector3<Pack> bu(b * u[0], b * u[1], b * u[2]);
  A.diagonal += Vector3<Pack>(bu[0] * u[0] + a, bu[1] * u[1] + a, bu[2] * u[2] + a);
  A.off += Vector3<Pack>(bu[1] * u[2], bu[0] * u[2], bu[0] * u[1]);
}
/// Returns K - K E K.
inline SymmetricPack eliminated(const SlotMass& K, const SymmetricPack& E) noexcept {
  // e = a b E u:  K E K = a^2 E + e u^T + u e^T + b^2 (u . E u) u u^T
  const auto& [u, a, b] = K;
  const Vector3<Pack> Eu = E * u;
  const Pack ab = a * b, a_sq = a * a, left = b - b * b * u.dot(Eu);
  const Vector3<Pack> e(ab * Eu[0], ab * Eu[1], ab * Eu[2]);
  const Vector3<Pack> f(left * u[0] - e[0], left * u[1] - e[1], left * u[2] - e[2]);
  return {.diagonal = {f[0] * u[0] - e[0] * u[0] + (a - a_sq * E.diagonal[0]),
                       f[1] * u[1] - e[1] * u[1] + (a - a_sq * E.diagonal[1]),
                       f[2] * u[2] - e[2] * u[2] + (a - a_sq * E.diagonal[2])},
          .off = {f[1] * u[2] - u[1] * e[2] - a_sq * E.off[0], f[0] * u[2] - u[0] * e[2] - a_sq * E.off[1],
                  f[0] * u[1] - u[0] * e[1] - a_sq * E.off[2]}};
}

/// Returns the blocks of a group's nodes, one per lane.
template <std::size_t max_nodes>
SymmetricPack in_lanes(const std::array<SymmetricBlock, max_nodes>& A, const NodeGroup& group) noexcept {
  const auto& n = group.nodes;
  return in_lanes(A[n[0]], A[n[1]], A[n[2]], A[n[3]]);
}

/// Adds the effective masses of all contacts at their nodes.
template <class Net, std::size_t N>
void add_masses_of_contacts(NetStage<Net, N>& w) noexcept {
  for (const NetContactTerm& contact : w.terms())
    each_node_of(contact, [&](std::uint32_t n, Real share) noexcept {
      SymmetricBlock K = outer_square(contact.n, share * contact.b);
      w.of_contacts[n] += (K += SymmetricBlock::multiple(share * contact.a));
    });
}

/// Factors the nodes with their springs, anchors and contacts.
template <class Net, std::size_t N>
void factor_nodes(NetStage<Net, N>& w) noexcept {
  auto& D = w.D;
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    D[n] = SymmetricBlock::multiple(w.m[n] + w.kappa[n] + w.settling[n]);
    w.of_contacts[n] = SymmetricBlock::zero();
  }
  add_masses_of_contacts(w);
  for (std::size_t g = 0; g < w.par->num_groups; ++g) {
    const NodeGroup& group = w.par->groups[g];
    SymmetricPack D_i = in_lanes(D, group);
    for (std::uint32_t s = group.first; s < group.end; ++s) add(w.masses[s], D_i);
    const std::array<SymmetricBlock, 4> D_n = blocks(D_i);
    // in reverse: unused lanes repeat the first node, whose own lane must be stored last
    for (std::size_t j = 4; j-- > 0;) D[group.nodes[j]] = D_n[j];
    const SymmetricPack E = w.D_inverse[g] = inverse(D_i + in_lanes(w.of_contacts, group));
    for (std::uint32_t s = group.first; s < group.end; ++s) {
      const std::array<SymmetricBlock, 4> left = blocks(eliminated(w.masses[s], E));
      for (std::size_t j = 0; j < 4; ++j) D[w.par->slots[s].others[j]] += left[j];
    }
  }
}

/// Updates D^-1 of the groups with contacts.
template <class Net, std::size_t N>
void renew_inverses(NetStage<Net, N>& w) noexcept {
  const auto renew = [&](std::uint32_t n, Real) noexcept {
    const std::uint32_t g = w.par->places[n].group;
    const NodeGroup& group = w.par->groups[g];
    w.D_inverse[g] = inverse(in_lanes(w.D, group) + in_lanes(w.of_contacts, group));
  };
  for (const NetContactTerm& contact : w.terms()) each_node_of(contact, renew);
}
/// Removes the contacts of nodes from their D; below, adds them. Their effect on other D remains as factored.
/// The preconditioner stays valid, because D_j is positive definite without the contacts of j.
template <class Net, std::size_t N>
void remove_contacts_from_factor(NetStage<Net, N>& w) noexcept {
  const auto remove = [&](std::uint32_t n, Real) noexcept { w.of_contacts[n] = SymmetricBlock::zero(); };
  for (const NetContactTerm& contact : w.terms()) each_node_of(contact, remove);
  renew_inverses(w);
}
/// Adds the contacts of nodes to D, after the previous ones were removed. A node may have several.
template <class Net, std::size_t N>
void add_contacts_to_factor(NetStage<Net, N>& w) noexcept {
  add_masses_of_contacts(w);
  renew_inverses(w);
}

/// Solves z = M^-1 r; r is overwritten.
template <class Net, std::size_t N, class Vector>
void solve_nodes(const NetStage<Net, N>& w, Vector& r, Vector& z) noexcept {
  const auto groups = w.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const NodeGroup& group = groups[g];
    const Vector3<Pack> z_i = w.D_inverse[g] * in_lanes(r, group.nodes);
    const std::array<Column, 4> z_n = columns(z_i);
    for (std::size_t j = 4; j-- > 0;) z[group.nodes[j]] = z_n[j];
    for (std::uint32_t s = group.first; s < group.end; ++s)
      add_lanes(w.masses[s] * z_i, w.par->slots[s].others, r);
  }
  for (std::size_t g = groups.size(); g-- > 0;) {
    const NodeGroup& group = groups[g];
    Vector3<Pack> sum = Vector3<Pack>::Constant(Pack(0));
    for (std::uint32_t s = group.first; s < group.end; ++s)
      sum += w.masses[s] * in_lanes(z, w.par->slots[s].others);
    add_lanes(w.D_inverse[g] * sum, group.nodes, z);
  }
}

}  // namespace godobject
