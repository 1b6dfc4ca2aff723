// A body on a joint in the factor of an island: its column is that of the joint's coordinates.
//
// When body c is eliminated, its children are out of the system, and of its joints the one to body p is left. With S and
// X as in (30),
//
//   (33)  V_c = X V_p + S q':  A_ip += A_ic X,  A_pp += X^T A_cc X + A_pc X + X^T A_cp,
//         A_pc := (A_pc + X^T A_cc) S,  A_ic := A_ic S,  A_cc := S^T A_cc S + D_stop
//
// and (31) eliminates q' as it does the twists of others.
#pragma once

#include "core/joint/edges.h"
#include "core/system/coupling_block.h"

namespace godobject {

/// How body k, by number in the factor, hangs.
struct FactoredJoint {
  bool is_free = true;
  bool on_world = false;
  int num_axes = 0;
  std::uint32_t parent = 0;      // number of the body it hangs on
  Column d;                      // from there to its centre of mass
  std::array<AnchorTwist, 3> s;  // at its centre of mass

  bool hangs() const noexcept { return !is_free && !on_world; }
};

/// A X.
inline CouplingBlock shifted(const CouplingBlock& A, const Column& d) noexcept {
  return {.ww = A.ww - cross(A.wv, d), .wv = A.wv, .vw = A.vw - cross(A.vv, d), .vv = A.vv};
}
/// A S, in the columns of w.
inline CouplingBlock along_axes(const CouplingBlock& A, const FactoredJoint& joint) noexcept {
  CouplingBlock along = no_coupling();
  for (std::size_t k = 0; k < static_cast<std::size_t>(joint.num_axes); ++k) {
    const AnchorTwist U = A * joint.s[k];
    along.ww.col[k] = U.w;
    along.vw.col[k] = U.v;
  }
  return along;
}
/// S^T F, in w.
inline AnchorTwist along_axes(const AnchorTwist& F, const FactoredJoint& joint) noexcept {
  Vec3 tau = Vec3::Zero();
  for (int k = 0; k < joint.num_axes; ++k) tau[k] = dot(joint.s[static_cast<std::size_t>(k)], F);
  return {.w = Column(tau), .v = Column(Pack(0))};
}
/// S^T A S + D_stop, in ww; ones where there is no axis.
inline TwistBlock along_axes(const TwistBlock& A, const FactoredJoint& joint,
                             const JointEdge& edge) noexcept {
  const Column none(Pack(0));
  TwistBlock along{.ww = Block::identity(), .wv = {{none, none, none}}, .vv = Block::identity()};
  for (std::size_t k = 0; k < static_cast<std::size_t>(joint.num_axes); ++k) {
    along.ww.col[k] = along_axes(A * joint.s[k], joint).w;
    if (k < edge.stop_D.size()) along.ww.col[k].p.set(k, along.ww.col[k].p[k] + edge.stop_D[k]);
  }
  return along;
}
/// S q'.
inline AnchorTwist along_axes(const FactoredJoint& joint, const Column& q_dot) noexcept {
  const Vec3 q = q_dot.vec();
  AnchorTwist V{.w = Column(Pack(0)), .v = Column(Pack(0))};
  for (int k = 0; k < joint.num_axes; ++k) V = V + joint.s[static_cast<std::size_t>(k)] * q[k];
  return V;
}

/// A + B + B^T.
inline void add_both(const CouplingBlock& B, TwistBlock& A) noexcept {
  A.ww += B.ww + transposed(B.ww);
  A.wv += B.wv + transposed(B.vw);
  A.vv += B.vv + transposed(B.vv);
}

}  // namespace godobject
