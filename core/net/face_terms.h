// Contacts of nodes with faces of nets in the system.
//
//   (60)  x' = v_n - sum w_m v_m;  impulse J - K x' on the node, -w_m times it on the face's nodes;
//         K = a 1 + b n n^T as of other contacts (24)
//
// Levers of friction, as long as the net is thick, are left to (48).
#pragma once

#include "core/net/scratch.h"

namespace godobject {

/// Returns the weighted sum of vectors of a face's nodes.
template <class Vector>
Column at_face(const FaceTouch& on, const Vector& v) noexcept {
  return v[on.nodes[0]] * on.weights[0] + v[on.nodes[1]] * on.weights[1] + v[on.nodes[2]] * on.weights[2];
}
/// Subtracts an impulse from a face's nodes by the weights.
template <class Vector>
void subtract_at_face(const FaceTouch& on, const Column& J, Vector& F) noexcept {
  for (std::size_t m = 0; m < 3; ++m) F[on.nodes[m]] -= J * on.weights[static_cast<Eigen::Index>(m)];
}

/// Returns the effective mass of the point of a face, kg.
template <class Net, std::size_t N>
Real mass_at_face(const FaceTouch& on, const NetStage<Net, N>& w) noexcept {
  Real per_mass = 0;
  for (std::size_t m = 0; m < 3; ++m) {
    const Real weight = on.weights[static_cast<Eigen::Index>(m)];
    per_mass += weight * weight / w.m[on.nodes[m]];
  }
  return 1 / per_mass;
}

/// Returns the impulse of a contact at the velocities v of nodes, without J.
template <class Vector>
Column resistance(const NetFaceTerm& term, const Vector& v) noexcept {
  const Column x_dot = v[term.node] - at_face(term.on, v);
  return x_dot * term.a + term.n * (term.b * dot(term.n, x_dot));
}

/// Computes AV += A_faces v (60).
template <class Net, std::size_t N, class Vector>
void add_faces_product(const NetStage<Net, N>& w, const Vector& v, Vector& AV) noexcept {
  for (std::size_t c = 0; c < w.faces.num_terms; ++c) {
    const NetFaceTerm& term = w.faces.terms[c];
    const Column J = resistance(term, v);
    AV[term.node] += J;
    subtract_at_face(term.on, J, AV);
  }
}

/// Calls f(node, squared weight of the contact at it) for the four nodes of a contact.
template <class F>
void each_end(const NetFaceTerm& term, F f) noexcept {
  f(term.node, Real(1));
  for (std::size_t m = 0; m < 3; ++m) {
    const Real weight = term.on.weights[static_cast<Eigen::Index>(m)];
    f(term.on.nodes[m], weight * weight);
  }
}

/// Adds the effective masses of the contacts with faces to those of the nodes' contacts.
template <class Net, std::size_t N>
void add_faces_to_nodes(NetStage<Net, N>& w) noexcept {
  if constexpr (Net::max_faces > 0)
    for (std::size_t c = 0; c < w.faces.num_terms; ++c) {
      const NetFaceTerm& term = w.faces.terms[c];
      each_end(term, [&](std::uint32_t n, Real share) noexcept {
        SymmetricBlock K = outer_square(term.n, share * term.b);
        w.of_contacts[n] += (K += SymmetricBlock::multiple(share * term.a));
      });
    }
}

/// Calls f(node) for all nodes of contacts with faces.
template <class Net, std::size_t N, class F>
void each_node_at_faces(const NetStage<Net, N>& w, F f) noexcept {
  if constexpr (Net::max_faces > 0)
    for (std::size_t c = 0; c < w.faces.num_terms; ++c)
      each_end(w.faces.terms[c], [&](std::uint32_t n, Real) noexcept { f(n); });
}

}  // namespace godobject
