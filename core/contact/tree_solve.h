// The solve of bodies that touch along the tree of their joints and stiffest contacts, and their product.
//
// Each pair of bodies has an impedance A_g for its relative twist, taken where the child's centre of mass is. With
// A_c of the child and all that hangs on it, X the shift from the parent,
//
//   (27)  V_c = S^-1 b_c + Y X V_p,  S = A_c + A_g,  Y = S^-1 A_g
//         A_p += X^T A_g (1 - Y) X,  b_p += X^T Y^T b_c
//
// and the joints by (30), core/joint/edges.h.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/contact/tree.h"

namespace godobject {

/// Beside an impedance this much larger than its mass, elimination forgets a body: the tree takes less of it, which
/// costs iterations and no accuracy.
inline constexpr Real max_contrast = 1e4;
inline Real stiffness_cap(const TwistBlock& A, Real mass) noexcept {
  const Real trace = A.vv.col[0].x() + A.vv.col[1].y() + A.vv.col[2].z();
  return std::min(Real(1), max_contrast * mass / std::max(trace, std::numeric_limits<Real>::min()));
}

/// (30)  The joint by which body i hangs out of the system.
template <std::size_t N, std::size_t max_pairs>
void eliminate_joint(std::uint32_t i, const JointEdge& joint, ContactTree<N, max_pairs, true>& w) noexcept {
  TouchingBody& c = w.bodies[i];
  c.hangs = c.parent != i;
  eliminate_axes(joint, w.joints.p[i], c.subtree_A, w.joints.axes[i]);
  if (c.hangs) add_to_parent(c.subtree_A, w.joints.p[i] - w.joints.p[c.parent], w.bodies[c.parent].subtree_A);
}

/// (27), (30) from the leaves up. subtree_A: A of the bodies, capped.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void eliminate(const Island& island, ContactTree<N, max_pairs, jointed>& w) noexcept {
  for (std::uint32_t k = island.end_body; k-- > island.first_body;) {
    const std::uint32_t i = w.order[k];
    TouchingBody& c = w.bodies[i];
    if constexpr (jointed) {
      if (const JointEdge* joint = w.joint_of(c)) {
        eliminate_joint(i, *joint, w);
        continue;
      }
    }
    c.hangs = c.parent != i && w.pairs[c.pair].touches;
    if (!c.hangs) {
      c.S_inverse = inverse(c.subtree_A);
      continue;
    }
    const TouchingPair& pair = w.pairs[c.pair];
    const TwistBlock A = pair.A * pair.stiffness_cap;
    c.S_inverse =
        inverse({.ww = c.subtree_A.ww + A.ww, .wv = c.subtree_A.wv + A.wv, .vv = c.subtree_A.vv + A.vv});
    const TwistBlock& S = c.S_inverse;
    const Block A_vw = transposed(A.wv), S_vw = transposed(S.wv);
    c.Y_ww = S.ww * A.ww + S.wv * A_vw;
    c.Y_wv = S.ww * A.wv + S.wv * A.vv;
    c.Y_vw = S_vw * A.ww + S.vv * A_vw;
    c.Y_vv = S_vw * A.wv + S.vv * A.vv;
    // A (1 - Y) as A_c S^-1 A: nothing cancels where A is much stiffer than the child is heavy
    TwistBlock rest;
    const TwistBlock& H = c.subtree_A;
    rest.ww = H.ww * c.Y_ww + H.wv * c.Y_vw;
    rest.wv = H.ww * c.Y_wv + H.wv * c.Y_vv;
    rest.vv = transposed(H.wv) * c.Y_wv + H.vv * c.Y_vv;
    add_to_parent(rest, pair.d, w.bodies[c.parent].subtree_A);
  }
}

/// (30)  The impulse on body i to where it hangs by its joint; S^T b stays in V[i].
template <std::size_t N, std::size_t max_pairs>
void hang_impulse(std::uint32_t i, const JointEdge& joint, const ContactTree<N, max_pairs, true>& w,
                  std::array<AnchorTwist, N>& b, std::array<AnchorTwist, N>& V) noexcept {
  const TouchingBody& c = w.bodies[i];
  V[i].w = Column(eliminate_axes(joint.num_axes, w.joints.axes[i], b[i]));
  if (c.hangs) b[c.parent] = b[c.parent] + moved_wrench(b[i], w.joints.p[i] - w.joints.p[c.parent]);
}

/// (30)  The twist of body i from that of what it hangs on by its joint.
template <std::size_t N, std::size_t max_pairs>
void solve_joint(std::uint32_t i, const JointEdge& joint, const ContactTree<N, max_pairs, true>& w,
                 std::array<AnchorTwist, N>& V) noexcept {
  const TouchingBody& c = w.bodies[i];
  const AnchorTwist V_P = c.hangs ? shifted(V[c.parent], w.joints.p[i] - w.joints.p[c.parent])
                                  : AnchorTwist{.w = Column(Pack(0)), .v = Column(Pack(0))};
  V[i] = solve_axes(joint.num_axes, w.joints.axes[i], V[i].w.vec(), V_P);
}

/// V = A^-1 b of the tree. b is used up.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void solve(const Island& island, const ContactTree<N, max_pairs, jointed>& w, std::array<AnchorTwist, N>& b,
           std::array<AnchorTwist, N>& V) noexcept {
  for (std::uint32_t k = island.end_body; k-- > island.first_body;) {
    const std::uint32_t i = w.order[k];
    const TouchingBody& c = w.bodies[i];
    if constexpr (jointed) {
      if (const JointEdge* joint = w.joint_of(c)) {
        hang_impulse(i, *joint, w, b, V);
        continue;
      }
    }
    if (!c.hangs) continue;
    const AnchorTwist& b_c = b[i];
    const AnchorTwist F = {.w = times_transposed(c.Y_ww, b_c.w) + times_transposed(c.Y_vw, b_c.v),
                           .v = times_transposed(c.Y_wv, b_c.w) + times_transposed(c.Y_vv, b_c.v)};
    b[c.parent] = b[c.parent] + moved_wrench(F, w.pairs[c.pair].d);
  }
  for (std::uint32_t k = island.first_body; k < island.end_body; ++k) {
    const std::uint32_t i = w.order[k];
    const TouchingBody& c = w.bodies[i];
    if constexpr (jointed) {
      if (const JointEdge* joint = w.joint_of(c)) {
        solve_joint(i, *joint, w, V);
        continue;
      }
    }
    V[i] = c.S_inverse * b[i];
    if (!c.hangs) continue;
    const AnchorTwist V_P = shifted(V[c.parent], w.pairs[c.pair].d);
    V[i] = V[i] + AnchorTwist{.w = c.Y_ww * V_P.w + c.Y_wv * V_P.v, .v = c.Y_vw * V_P.w + c.Y_vv * V_P.v};
  }
}

/// What the stops of an island's joints add to A V.
template <std::size_t N, std::size_t max_pairs>
void multiply_stops(const Island& island, const ContactTree<N, max_pairs, true>& w,
                    const std::array<AnchorTwist, N>& V, std::array<AnchorTwist, N>& AV) noexcept {
  w.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept {
    const JointEdge& joint = w.joints.edges[i];
    for (int k = 0; k < std::min(joint.num_axes, 2); ++k) {
      const Real D = joint.stop_D[static_cast<std::size_t>(k)];
      if (D == 0) continue;
      const AnchorTwist e = axis_wrench(joint, k, w.joints.p[i]);
      if (!joint.on_body()) {
        AV[i] = AV[i] + e * (D * dot(e, V[i]));
        continue;
      }
      const Column d = w.joints.p[i] - w.joints.p[joint.parent];
      const AnchorTwist F = e * (D * dot(e, V[i] - shifted(V[joint.parent], d)));
      AV[i] = AV[i] + F;
      AV[joint.parent] = AV[joint.parent] - moved_wrench(F, d);
    }
  });
}

/// A V of all pairs, in the tree or not.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void multiply(const Island& island, const ContactTree<N, max_pairs, jointed>& w,
              const std::array<AnchorTwist, N>& V, std::array<AnchorTwist, N>& AV) noexcept {
  w.each_body(island, [&](std::uint32_t i, const TouchingBody& body) noexcept { AV[i] = body.A * V[i]; });
  w.each_pair(island, [&](const TouchingPair& pair) noexcept {
    if (!pair.touches) return;
    const AnchorTwist F = pair.A * (V[pair.child] - shifted(V[pair.parent], pair.d));
    AV[pair.child] = AV[pair.child] + F;
    AV[pair.parent] = AV[pair.parent] - moved_wrench(F, pair.d);
  });
  if constexpr (jointed) multiply_stops(island, w, V, AV);
}

/// The largest of forces on the bodies of an island, about their centres of mass, that joints cannot bear. F is used up.
/// A torque tau about an axis counts as the force tau sqrt(m / I), alike in the energy that an impulse of it gives.
template <std::size_t N, std::size_t max_pairs, class Stages>
Real largest_unborne(const Island& island, const ContactTree<N, max_pairs, true>& w, const Stages& stages,
                     std::array<AnchorTwist, N>& F) noexcept {
  Real most = 0;
  for (std::uint32_t k = island.end_body; k-- > island.first_body;) {
    const std::uint32_t i = w.order[k];
    const TouchingBody& c = w.bodies[i];
    const JointEdge* joint = w.joint_of(c);
    if (joint == nullptr) {
      most = std::max(most, dot(F[i].v, F[i].v));
      continue;
    }
    for (int a = 0; a < joint->num_axes; ++a) {
      const AnchorTwist s = axis_twist(*joint, a, w.joints.p[i]);
      const Real M = stages[i].M, tau = dot(s, F[i]);
      most = std::max(most, tau * tau * M / (dot(s.w, stages[i].A_ww * s.w) + M * dot(s.v, s.v)));
    }
    if (c.hangs) F[c.parent] = F[c.parent] + moved_wrench(F[i], w.joints.p[i] - w.joints.p[c.parent]);
  }
  return std::sqrt(most);
}

}  // namespace godobject
