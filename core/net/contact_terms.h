// Contacts and attachments of nodes in the system: an impulse J - K x' on the node, its opposite on the other
// side. x': velocity relative to the touched point. On a face with nodes m,
//
//   (60)  x' = v_n - sum w_m v_m;  impulse J - K x' on the node, -w_m times it on the face's nodes;
//         K = a 1 + b n n^T as of other contacts (24)
//
// Levers of friction on faces, as long as the net is thick, are left to (48).
#pragma once

#include "core/net/scratch.h"

namespace godobject {

/// Calls f(node, weight) for the nodes of a face.
template <class F>
void each_weight(const PointOfFace& on, F f) noexcept {
  for (std::size_t m = 0; m < 3; ++m) f(on.nodes[m], on.weights[static_cast<Eigen::Index>(m)]);
}
/// Returns the weighted sum of vectors of a face's nodes.
template <class Vector>
Column at_face(const PointOfFace& on, const Vector& v) noexcept {
  return v[on.nodes[0]] * on.weights[0] + v[on.nodes[1]] * on.weights[1] + v[on.nodes[2]] * on.weights[2];
}
/// Subtracts an impulse from a face's nodes by the weights.
template <class Vector>
void subtract_at_face(const PointOfFace& on, const Column& J, Vector& F) noexcept {
  each_weight(on, [&](std::uint32_t n, Real weight) noexcept { F[n] -= J * weight; });
}

/// Returns the effective mass of the point of a face, kg.
template <class Net, std::size_t N>
Real mass_at_face(const PointOfFace& on, const NetStage<Net, N>& w) noexcept {
  Real per_mass = 0;
  each_weight(on, [&](std::uint32_t n, Real weight) noexcept { per_mass += weight * weight / w.m[n]; });
  return 1 / per_mass;
}

/// Returns the impulse of a contact at a relative velocity, without J.
inline Column resistance(const NetContactTerm& contact, const Column& x_dot) noexcept {
  return x_dot * contact.a + contact.n * (contact.b * dot(contact.n, x_dot));
}
/// Adds an impulse to the node of a contact, and its opposite to the body or face.
template <class Nodes, class Bodies>
void add_impulse(const NetContactTerm& contact, const Column& J, Nodes& nodes, Bodies& bodies) noexcept {
  nodes[contact.node] += J;
  if (contact.is_on_body())
    bodies[contact.body] = bodies[contact.body] - moved_wrench({.w = Column(Pack(0)), .v = J}, contact.r);
  else if (contact.is_on_face()) subtract_at_face(contact.face, J, nodes);
}
/// Computes AV += A_contacts V. v: velocities of the nodes relative to the world.
template <class Net, std::size_t N, class Nodes, class Vector>
void add_contacts_product(const NetStage<Net, N>& w, const Nodes& v, const Vector& V, Vector& AV) noexcept {
  for (const NetContactTerm& contact : w.terms()) {
    Column x_dot = v[contact.node];
    if (contact.is_on_body()) x_dot -= shifted(V.bodies[contact.body], contact.r).v;
    else if (contact.is_on_face()) x_dot -= at_face(contact.face, v);
    add_impulse(contact, resistance(contact, x_dot), AV.nodes, AV.bodies);
  }
}

/// Calls f(node, squared weight of the contact at it) for the node of a contact and those of its face.
template <class F>
void each_node_of(const NetContactTerm& contact, F f) noexcept {
  f(contact.node, Real(1));
  if (contact.is_on_face())
    each_weight(contact.face, [&](std::uint32_t n, Real weight) noexcept { f(n, weight * weight); });
}

}  // namespace godobject
