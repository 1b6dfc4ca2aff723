// The bodies of a tree of joints solved together, in time linear in their number: equation (7), eliminated
// from the leaves to the root and solved back, never as a matrix of the whole (docs/decisions/014).
//
// Unknown: the twist V = (w, v) of every body, world axes, v of its centre of mass. A body alone obeys
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
// What is left, F = A_child V_child - b_child, is the impulse of the joint on the child: S-free part, the multipliers.
#pragma once

#include "core/joint.h"

namespace godobject {

/// A body with everything that hangs on it: A V = b in 3 x 3 blocks.
struct ArticulatedBody {
  Mat3 A_ww, A_wv, A_vw, A_vv;
  Vec3 b_w, b_v;
};

/// What the way back needs of a joint with up to three coordinates.
struct EliminatedJoint {
  Mat3 S_w, S_v;  // columns: motion of the child's centre of mass per coordinate rate
  Mat3 T_w, T_v;  // rows: S^T A
  Mat3 D_inverse;
  Vec3 tau;  // S^T (b - A beta)
  Vec3 beta_w, beta_v;
  Vec3 d;  // from the parent's centre of mass to the child's
};

template <int D>
Eigen::Matrix<Real, D, D> inverse(const Eigen::Matrix<Real, D, D>& a) noexcept {
  if constexpr (D == 1) {
    return Eigen::Matrix<Real, 1, 1>(1 / a(0, 0));
  } else if constexpr (D == 2) {
    Eigen::Matrix<Real, 2, 2> r;
    r << a(1, 1), -a(0, 1), -a(1, 0), a(0, 0);
    return r * (1 / (a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0)));
  } else {
    const Vec3 c0 = a.col(1).cross(a.col(2)), c1 = a.col(2).cross(a.col(0)), c2 = a.col(0).cross(a.col(1));
    Mat3 r;
    r.row(0) = c0;
    r.row(1) = c1;
    r.row(2) = c2;
    return r * (1 / a.col(0).dot(c0));
  }
}

/// Eliminates child's joint (7): fills j and, unless the parent is the world, adds to the parent.
template <int D>
void eliminate(const ArticulatedBody& child, EliminatedJoint& j, ArticulatedBody* parent) noexcept {
  const Vec3 b_w = child.b_w - child.A_ww * j.beta_w - child.A_wv * j.beta_v;
  const Vec3 b_v = child.b_v - child.A_vw * j.beta_w - child.A_vv * j.beta_v;
  ArticulatedBody a = {child.A_ww, child.A_wv, child.A_vw, child.A_vv, b_w, b_v};
  if constexpr (D > 0) {
    using Columns = Eigen::Matrix<Real, 3, D>;
    using Rows = Eigen::Matrix<Real, D, 3>;
    const Columns S_w = j.S_w.template leftCols<D>(), S_v = j.S_v.template leftCols<D>();
    const Columns U_w = child.A_ww * S_w + child.A_wv * S_v;
    const Columns U_v = child.A_vw * S_w + child.A_vv * S_v;
    const Rows T_w = S_w.transpose() * child.A_ww + S_v.transpose() * child.A_vw;
    const Rows T_v = S_w.transpose() * child.A_wv + S_v.transpose() * child.A_vv;
    const Eigen::Matrix<Real, D, D> D_inverse =
        inverse<D>(Eigen::Matrix<Real, D, D>(S_w.transpose() * U_w + S_v.transpose() * U_v));
    const Eigen::Matrix<Real, D, 1> tau = S_w.transpose() * b_w + S_v.transpose() * b_v;
    const Columns P_w = U_w * D_inverse, P_v = U_v * D_inverse;
    a.A_ww -= P_w * T_w;
    a.A_wv -= P_w * T_v;
    a.A_vw -= P_v * T_w;
    a.A_vv -= P_v * T_v;
    a.b_w -= P_w * tau;
    a.b_v -= P_v * tau;
    j.T_w.template topRows<D>() = T_w;
    j.T_v.template topRows<D>() = T_v;
    j.D_inverse.template topLeftCorner<D, D>() = D_inverse;
    j.tau.template head<D>() = tau;
  }
  if (parent == nullptr) return;
  const Mat3 d = skew(j.d);
  const Mat3 A_vw = a.A_vw - a.A_vv * d;
  parent->A_ww += a.A_ww - a.A_wv * d + d * A_vw;
  parent->A_wv += a.A_wv + d * a.A_vv;
  parent->A_vw += A_vw;
  parent->A_vv += a.A_vv;
  parent->b_w += a.b_w + j.d.cross(a.b_v);
  parent->b_v += a.b_v;
}

/// (5) with q' from the elimination: the child's twist from its parent's (zero for the world).
template <int D>
Twist solved(const EliminatedJoint& j, const Twist& parent) noexcept {
  const Vec3 w = parent.w;
  const Vec3 v = parent.v + parent.w.cross(j.d);
  Twist V = {.w = w + j.beta_w, .v = v + j.beta_v};
  if constexpr (D > 0) {
    const Eigen::Matrix<Real, D, 1> rate =
        j.D_inverse.template topLeftCorner<D, D>() *
        (j.tau.template head<D>() - j.T_w.template topRows<D>() * w - j.T_v.template topRows<D>() * v);
    V.w += j.S_w.template leftCols<D>() * rate;
    V.v += j.S_v.template leftCols<D>() * rate;
  }
  return V;
}

/// A root without a joint: A V = b itself, by its 3 x 3 blocks.
inline Twist solved(const ArticulatedBody& root) noexcept {
  const Mat3 A_vv_inverse = inverse<3>(root.A_vv);
  const Mat3 B = root.A_wv * A_vv_inverse;
  const Vec3 w = inverse<3>(Mat3(root.A_ww - B * root.A_vw)) * (root.b_w - B * root.b_v);
  return {.w = w, .v = A_vv_inverse * (root.b_v - root.A_vw * w)};
}

}  // namespace godobject
