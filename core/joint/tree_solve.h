// The bodies of a tree of joints solved together, in time linear in their number: equation (7), eliminated
// from the leaves to the root and solved back, never as a matrix of the whole (docs/decisions/014).
//
// Unknown: the twist V = (w, v) of every body, world axes, v of the anchor of its joint. A body alone obeys
// A V = b (its stage, (10) and (11)). A joint says how its body may move against its parent,
//
//   (5)   V_child = X V_parent + S q' + beta
//
// with S the allowed motion, beta what takes back the violation, X the shift of a rigid motion. The
// multipliers of (4) act across S only, S^T (A V - b) = 0, which eliminates q' and then the child:
//
//   (7)   D = S^T A S,  A_a = A - A S D^-1 S^T A,  b_a = (1 - A S D^-1 S^T) (b - A beta)
//         A_parent += X^T A_a X,  b_parent += X^T b_a
//
// one axis of S after the other, so D is a number; all three turns of a ball joint at once, with a 3 x 3 D.
// What is left, F = A_a X V_parent - b_a, is the impulse of the joint on the child: the multipliers.
#pragma once

#include "core/joint/joint.h"
#include "core/math/spatial.h"

namespace godobject {

/// A body with everything that hangs on it: A V = b, V at the anchor of its joint.
struct ArticulatedBody {
  SpatialMatrix A;
  SpatialVector b;
};

/// What acts along an eliminated axis itself: adds to its D and its tau.
struct AxisTerms {
  Real D = 0;
  Real tau = 0;
};

/// An eliminated axis: q' = (tau - T V) / D with V the twist without it.
struct EliminatedAxis {
  Column s;         // unit
  Column T_w, T_v;  // S^T A
  Real tau = 0, D_inverse = 0;
};

/// b - A beta.
inline void add_bias(ArticulatedBody& a, const SpatialVector& beta) noexcept {
  a.b.w -= a.A.ww * beta.w + a.A.wv * beta.v;
  a.b.v -= a.A.vw * beta.w + a.A.vv * beta.v;
}

/// The same for a beta without a turn.
inline void add_shift_bias(ArticulatedBody& a, const Column& beta_v) noexcept {
  a.b.w -= a.A.wv * beta_v;
  a.b.v -= a.A.vv * beta_v;
}

/// (7) for one axis s, a turn about it or a slide along it: U = A S, T = S^T A, b - U tau / D and A - U T / D. along: what
/// acts on the coordinate itself, a stop. has_parent: A_a is needed; with nothing to hang on, b alone is asked for.
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

/// Eliminates all turns: w = y - Y v with v the velocity of the anchor. What is left of the body is a mass, A_vv and
/// b_v; Y and y take the places of A_wv and b_w.
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

/// Shifted to an anchor d away (from the parent's to the child's) and added to the parent: v_child = v - [d]x w.
inline void add_to_parent(const ArticulatedBody& a, const Column& d, ArticulatedBody& parent) noexcept {
  add_to_parent(a.A, d, parent.A);
  parent.b = parent.b + moved_wrench(a.b, d);
}

/// The same where only a mass is left.
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
