// An incomplete factor of the nodes of nets: what their conjugate gradients are preconditioned with.
//
//   (43)  M = (D + L) D^-1 (D + L^T),  L what springs couple, below the diagonal;  D_j = A_jj - sum_{i < j} K_ij D_i^-1 K_ij
//
// the diagonal alone is changed as it is factored (Meijerink and van der Vorst 1977). Every D is positive definite: if
// D_i >= sum of the K_il, l > i, then K_ij D_i^-1 K_ij <= K_ij, and what is left of A_jj, the sum of all K at j and the mass,
// is D_j >= sum of the K_jl, l > j, and the mass. Nodes are taken in the order of NetParams: the factor is that of their
// numbers.
#pragma once

#include "core/net/springs.h"

namespace godobject {

/// Effective mass K of a spring.
inline Block effective_mass(const Pack& q_a) noexcept {
  const Column q(q_a);
  Block K = outer(q, q);
  if (q_a[3] > 0) K += Block::identity() * q_a[3];
  return K;
}
/// D += K - K E K, K = a 1 + q q^T.
inline void add_eliminated(const Pack& q_a, const Block& E, Block& D) noexcept {
  const Column q(q_a), e = E * q;
  const Real a = q_a[3];
  D += outer(q * (1 - dot(q, e)), q);
  if (!(a > 0)) return;
  D += Block::identity() * a;
  D -= E * (a * a);
  D -= outer(e * a, q) + outer(q * a, e);
}

/// Effective mass of a contact.
inline Block effective_mass(const NetContactTerm& contact) noexcept {
  return Block::identity() * contact.a + outer(contact.n * contact.b, contact.n);
}

/// Factors the nodes as their springs, anchors and contacts are.
template <class Net, std::size_t N>
void factor_nodes(NetStage<Net, N>& w) noexcept {
  auto& D = w.D;
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    D[n] = Block::identity() * (w.m[n] + w.kappa[n]);
    w.of_contacts[n] = Block::zero();
  }
  for (std::size_t c = 0; c < w.num_contacts; ++c)
    w.of_contacts[w.contacts[c].node] += effective_mass(w.contacts[c]);
  for (std::uint32_t o = 0; o < w.num_nodes; ++o) {
    const std::uint32_t i = w.order[o], s = w.first_of[i + 1];
    Block D_i = D[i];
    for (std::uint32_t t = w.first_of[i]; t < s; ++t) D_i += effective_mass(w.q_a[t]);
    D[i] = D_i;
    D_i = w.D_inverse[i] = inverse(D_i + w.of_contacts[i]);
    for (std::uint32_t t = w.first_of[i]; t < s; ++t) add_eliminated(w.q_a[t], D_i, D[w.other[t]]);
  }
}

/// The contacts of nodes, out of their D and into it: what they change elsewhere is left as it was factored, a
/// preconditioner all the same, since D_j is positive definite without the contacts of j.
template <class Net, std::size_t N>
void take_contacts_out(NetStage<Net, N>& w) noexcept {
  for (std::size_t c = 0; c < w.num_contacts; ++c) {
    const std::uint32_t n = w.contacts[c].node;
    w.D_inverse[n] = inverse(w.D[n]);
  }
}
template <class Net, std::size_t N>
void put_contacts_in(NetStage<Net, N>& w) noexcept {
  auto& of_node = w.of_contacts;  // which may touch more than one thing
  for (std::size_t c = 0; c < w.num_contacts; ++c) of_node[w.contacts[c].node] = Block::zero();
  for (std::size_t c = 0; c < w.num_contacts; ++c)
    of_node[w.contacts[c].node] += effective_mass(w.contacts[c]);
  for (std::size_t c = 0; c < w.num_contacts; ++c) {
    const std::uint32_t n = w.contacts[c].node;
    w.D_inverse[n] = inverse(w.D[n] + of_node[n]);
  }
}

/// z = M^-1 r; r is used up.
template <class Net, std::size_t N, class Vector>
void solve_nodes(const NetStage<Net, N>& w, Vector& r, Vector& z) noexcept {
  for (std::uint32_t o = 0; o < w.num_nodes; ++o) {
    const std::uint32_t i = w.order[o];
    const Column z_i = z[i] = w.D_inverse[i] * r[i];
    for (std::uint32_t s = w.first_of[i], end = w.first_of[i + 1]; s < end; ++s)
      r[w.other[s]] += spring_product(w.q_a[s], z_i);
  }
  for (std::uint32_t o = static_cast<std::uint32_t>(w.num_nodes); o-- > 0;) {
    const std::uint32_t i = w.order[o];
    Column sum(Pack(0));
    for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s)
      sum += spring_product(w.q_a[s], z[w.other[s]]);
    z[i] += w.D_inverse[i] * sum;
  }
}

}  // namespace godobject
