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

#include "core/implicit_stage.h"
#include "core/joint.h"

namespace godobject {

/// A body with everything that hangs on it: A V = b in 3 x 3 blocks.
struct ArticulatedBody {
  Mat3 A_ww, A_wv, A_vw, A_vv;
  Vec3 b_w, b_v;
};

/// An eliminated axis: q' = (tau - T V) / D with V the twist without it.
struct EliminatedAxis {
  Vec3 s;         // unit
  Vec3 T_w, T_v;  // S^T A
  Real tau, D_inverse;
};

/// What acts along an eliminated axis itself: adds to its D and its tau.
struct AxisTerms {
  Real D = 0;
  Real tau = 0;
};

inline Mat3 inverse(const Mat3& a) noexcept {
  const Vec3 a0 = a.col(0), a1 = a.col(1), a2 = a.col(2);
  const Vec3 c0 = a1.cross(a2), c1 = a2.cross(a0), c2 = a0.cross(a1);
  const Real r = 1 / a0.dot(c0);
  Mat3 inverted;
  inverted.row(0) = r * c0;
  inverted.row(1) = r * c1;
  inverted.row(2) = r * c2;
  return inverted;
}

/// b - A beta.
inline void set_off(ArticulatedBody& a, const Twist& beta) noexcept {
  a.b_w -= a.A_ww * beta.w + a.A_wv * beta.v;
  a.b_v -= a.A_vw * beta.w + a.A_vv * beta.v;
}

/// Takes the rest of (7) for one axis, b - U tau / D and A - U T / D; with nothing to hang on, b alone is asked for.
inline void reduce(ArticulatedBody& a, const Vec3& U_w, const Vec3& U_v, const EliminatedAxis& j,
                   bool hangs) noexcept {
  const Vec3 P_w = U_w * j.D_inverse, P_v = U_v * j.D_inverse;
  a.b_w -= P_w * j.tau;
  a.b_v -= P_v * j.tau;
  if (!hangs) return;
  for (int c = 0; c < 3; ++c) {
    a.A_ww.col(c) -= P_w * j.T_w[c];
    a.A_vw.col(c) -= P_v * j.T_w[c];
    a.A_wv.col(c) -= P_w * j.T_v[c];
    a.A_vv.col(c) -= P_v * j.T_v[c];
  }
}

/// Eliminates a turn about s. along: what acts on the coordinate itself, a stop. hangs: A_a is needed.
inline void eliminate_turn(ArticulatedBody& a, const Vec3& s, const AxisTerms& along, EliminatedAxis& j,
                           bool hangs) noexcept {
  const Vec3 U_w = a.A_ww * s, U_v = a.A_vw * s;
  j = {.s = s,
       .T_w = a.A_ww.transpose() * s,
       .T_v = a.A_wv.transpose() * s,
       .tau = s.dot(a.b_w) + along.tau,
       .D_inverse = 1 / (s.dot(U_w) + along.D)};
  reduce(a, U_w, U_v, j, hangs);
}

/// Eliminates a slide along s.
inline void eliminate_slide(ArticulatedBody& a, const Vec3& s, const AxisTerms& along, EliminatedAxis& j,
                            bool hangs) noexcept {
  const Vec3 U_w = a.A_wv * s, U_v = a.A_vv * s;
  j = {.s = s,
       .T_w = a.A_vw.transpose() * s,
       .T_v = a.A_vv.transpose() * s,
       .tau = s.dot(a.b_v) + along.tau,
       .D_inverse = 1 / (s.dot(U_v) + along.D)};
  reduce(a, U_w, U_v, j, hangs);
}

/// Eliminates all turns: w = y - Y v with v the velocity of the anchor. What is left of the body is a mass, A_vv and
/// b_v; Y and y take the places of A_wv and b_w.
inline void eliminate_turns(ArticulatedBody& a) noexcept {
  const Mat3 D_inverse = inverse(a.A_ww);
  const Mat3 Y = D_inverse * a.A_wv;
  const Vec3 y = D_inverse * a.b_w;
  a.A_vv -= a.A_vw * Y;
  a.b_v -= a.A_vw * y;
  a.A_wv = Y;
  a.b_w = y;
}

inline Real rate(const EliminatedAxis& j, const Twist& V) noexcept {
  return (j.tau - j.T_w.dot(V.w) - j.T_v.dot(V.v)) * j.D_inverse;
}

/// A shifted to an anchor d away (from the parent's to the child's) and added to the parent.
inline void hang(const ArticulatedBody& a, const Vec3& d, ArticulatedBody& parent) noexcept {
  // v_child = v - [d]x w
  const Mat3 X = skew(d);
  const Mat3 A_vw = a.A_vw - a.A_vv * X;
  parent.A_ww += a.A_ww - a.A_wv * X + X * A_vw;
  parent.A_wv += a.A_wv + X * a.A_vv;
  parent.A_vw += A_vw;
  parent.A_vv += a.A_vv;
  parent.b_w += a.b_w + d.cross(a.b_v);
  parent.b_v += a.b_v;
}

/// The same where only a mass is left.
inline void hang_mass(const ArticulatedBody& a, const Vec3& d, ArticulatedBody& parent) noexcept {
  const Mat3 X = skew(d);
  const Mat3 A_vw = a.A_vv * X;
  parent.A_ww -= X * A_vw;
  parent.A_wv += X * a.A_vv;
  parent.A_vw -= A_vw;
  parent.A_vv += a.A_vv;
  parent.b_w += d.cross(a.b_v);
  parent.b_v += a.b_v;
}

/// The twist of the same rigid motion d away.
inline Twist shifted(const Twist& V, const Vec3& d) noexcept { return {.w = V.w, .v = V.v + V.w.cross(d)}; }

/// A root without a joint: A V = b itself, by its 3 x 3 blocks.
inline Twist solved(const ArticulatedBody& root) noexcept {
  const Mat3 A_vv_inverse = inverse(root.A_vv);
  const Mat3 B = root.A_wv * A_vv_inverse;
  const Vec3 w = solve3(Mat3(root.A_ww - B * root.A_vw), Vec3(root.b_w - B * root.b_v));
  return {.w = w, .v = A_vv_inverse * (root.b_v - root.A_vw * w)};
}

}  // namespace godobject
