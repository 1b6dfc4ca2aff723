// Solution of a tree of jointed bodies in linear time (7): elimination from the leaves to the root, then back
// substitution. No matrix of the whole is formed (docs/decisions/014).
//
// Unknown: the twist V = (w, v) of every body, world axes, v of the anchor of its joint. A free body obeys A
// V = b, its stage (10) and (11). A joint restricts the motion of its body against the parent,
//
//   (5)   V_child = X V_parent + S q' + beta
//
// with S the allowed motion, beta the correction of the violation, X the shift of a rigid motion. The
// multipliers of (4) act across S only, S^T (A V - b) = 0, which eliminates q' and then the child:
//
//   (7)   D = S^T A S,  A_a = A - A S D^-1 S^T A,  b_a = (1 - A S D^-1 S^T) (b - A beta)
//         A_parent += X^T A_a X,  b_parent += X^T b_a
//
// Axes of S are eliminated one after the other, so D is a number. The rotations of a ball joint are
// eliminated at once, with a 3 x 3 D. The residual F = A_a X V_parent - b_a is the impulse of the joint on
// the child: the multipliers.
#pragma once

#include "core/joint/joint.h"
#include "core/math/spatial.h"

namespace godobject {

/// Articulated body, with all its descendants: A V = b, V at the anchor of its joint.
struct ArticulatedBody {
  SpatialMatrix A;
  SpatialVector b;
};

/// Effective mass and impulse along an eliminated axis, added to its D and tau.
struct AxisTerms {
  Real D = 0;
  Real tau = 0;
};

/// Eliminated axis: q' = (tau - T V) / D, V the twist without it.
struct EliminatedAxis {
  Column s;         // unit
  Column T_w, T_v;  // S^T A
  Real tau = 0, D_inverse = 0;
};

/// Replaces b by b - A beta.
inline void add_bias(ArticulatedBody& a, const SpatialVector& beta) noexcept {
  a.b.w -= a.A.ww * beta.w + a.A.wv * beta.v;
  a.b.v -= a.A.vw * beta.w + a.A.vv * beta.v;
}

/// As add_bias, for a beta without rotation.
inline void add_shift_bias(ArticulatedBody& a, const Column& beta_v) noexcept {
  a.b.w -= a.A.wv * beta_v;
  a.b.v -= a.A.vv * beta_v;
}

/// Eliminates one axis s (7), a rotation or a translation: U = A S, T = S^T A, b - U tau / D and A - U T / D.
/// along: terms on the coordinate itself, of a stop. has_parent: A_a is needed; otherwise only b is computed.
template <bool turns>
void eliminate_axis(ArticulatedBody& a, const Column& s, const AxisTerms& along, EliminatedAxis& j,
                    bool has_parent) noexcept {
  const Column U_w = (turns ? a.A.ww : a.A.wv) * s, U_v = (turns ? a.A.vw : a.A.vv) * s;
  j.s = s;
  j.T_w = times_transposed(turns ? a.A.ww : a.A.vw, s);
  j.T_v = times_transposed(turns ? a.A.wv : a.A.vv, s);
  j.tau = dot(s, turns ? a.b.w : a.b.v) + along.tau;
  j.D_inverse = 1 / (dot(s, turns ? U_w : U_v) + along.D);
  const Column P_w = U_w * j.D_inverse, P_v = U_v * j.D_inverse;
  a.b.w -= P_w * j.tau;
  a.b.v -= P_v * j.tau;
  if (!has_parent) return;
  a.A.ww -= outer(P_w, j.T_w);
  a.A.vw -= outer(P_v, j.T_w);
  a.A.wv -= outer(P_w, j.T_v);
  a.A.vv -= outer(P_v, j.T_v);
}

/// Eliminates all rotations: w = y - Y v, v the velocity of the anchor. The remaining body is a mass, A_vv
/// and b_v. Y and y replace A_wv and b_w.
inline void eliminate_turns(ArticulatedBody& a) noexcept {
  const Block D_inverse = inverse(a.A.ww);
  const Block Y = D_inverse * a.A.wv;
  const Column y = D_inverse * a.b.w;
  a.A.vv -= a.A.vw * Y;
  a.b.v -= a.A.vw * y;
  a.A.wv = Y;
  a.b.w = y;
}

inline Real rate(const EliminatedAxis& j, const SpatialVector& V) noexcept {
  return (j.tau - dot(j.T_w, V.w) - dot(j.T_v, V.v)) * j.D_inverse;
}

/// Shifts an articulated body by d, from the parent's anchor to the child's, and adds it to the parent:
/// v_child = v - [d]x w.
inline void add_to_parent(const ArticulatedBody& a, const Column& d, ArticulatedBody& parent) noexcept {
  add_to_parent(a.A, d, parent.A);
  parent.b = parent.b + moved_wrench(a.b, d);
}

/// As add_to_parent, for a body reduced to a mass.
inline void add_mass_to_parent(const ArticulatedBody& a, const Column& d, ArticulatedBody& parent) noexcept {
  const Block A_vw = cross(a.A.vv, d);
  parent.A.ww -= cross(d, A_vw);
  parent.A.wv += cross(d, a.A.vv);
  parent.A.vw -= A_vw;
  parent.A.vv += a.A.vv;
  parent.b.w += cross(d, a.b.v);
  parent.b.v += a.b.v;
}

}  // namespace godobject
