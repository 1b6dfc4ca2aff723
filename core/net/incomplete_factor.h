// An incomplete factor of the nodes of nets: what their conjugate gradients are preconditioned with.
//
//   (43)  M = (D + L) D^-1 (D + L^T),  L what springs couple, below the diagonal;  D_j = A_jj - sum_{i < j} K_ij D_i^-1 K_ij
//
// the diagonal alone is changed as it is factored (Meijerink and van der Vorst 1977). Every D is positive definite: if
// D_i >= sum of the K_il, l > i, then K_ij D_i^-1 K_ij <= K_ij, and what is left of A_jj, the sum of all K at j and the mass,
// is D_j >= sum of the K_jl, l > j, and the mass.
#pragma once

#include "core/net/springs.h"

namespace godobject {

/// D -= K E K, K = a 1 + q q^T.
inline void subtract_between(const Pack& q_a, const Block& E, Block& D) noexcept {
  const Column q(q_a), e = E * q;
  const Real a = q_a[3];
  D -= outer(q * dot(q, e), q);
  if (!(a > 0)) return;
  D -= E * (a * a);
  D -= outer(e * a, q) + outer(q * a, e);
}

/// Factors the nodes as their springs, anchors and contacts are.
template <class Net, std::size_t N>
void factor_nodes(NetStage<Net, N>& w) noexcept {
  auto& D = w.D_inverse;
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) D[n] = Block::identity() * (w.m[n] + w.kappa[n]);
  for (std::size_t c = 0; c < w.num_contacts; ++c) {
    const NetContactImpedance& contact = w.contacts[c];
    D[contact.node] += Block::identity() * contact.a;
    D[contact.node] += outer(contact.n * contact.b, contact.n);
  }
  each_spring(w, [&](std::uint32_t i, std::uint32_t j, std::uint32_t s) noexcept {
    const Column q(w.q_a[s]);
    Block K = outer(q, q);
    if (w.q_a[s][3] > 0) K += Block::identity() * w.q_a[s][3];
    D[i] += K;
    D[j] += K;
  });
  for (std::uint32_t i = 0; i < w.num_nodes; ++i) {
    D[i] = inverse(D[i]);
    for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s)
      subtract_between(w.q_a[s], D[i], D[w.other[s]]);
  }
}

/// z = M^-1 r; r is used up.
template <class Net, std::size_t N, class Vector>
void solve_nodes(const NetStage<Net, N>& w, Vector& r, Vector& z) noexcept {
  for (std::uint32_t i = 0; i < w.num_nodes; ++i) {
    z[i] = w.D_inverse[i] * r[i];
    for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s)
      r[w.other[s]] += spring_product(w.q_a[s], z[i]);
  }
  for (std::uint32_t i = static_cast<std::uint32_t>(w.num_nodes); i-- > 0;) {
    if (w.first_of[i] == w.first_of[i + 1]) continue;
    Column sum = Column(Pack(0));
    for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s)
      sum += spring_product(w.q_a[s], z[w.other[s]]);
    z[i] += w.D_inverse[i] * sum;
  }
}

}  // namespace godobject
