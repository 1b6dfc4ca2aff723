// Jointed unknown in the factor. Its block column is over the coordinates of the joint.
//
// When body c is eliminated, its children are eliminated already, and only its joint to body p remains. With
// V_c = X V_p + S q', a congruence of the whole matrix,
//
//   (33)  A_ip += A_ic X,  A_pp += X^T A_cc X + A_pc X + X^T A_cp,
//         A_pc := (A_pc + X^T A_cc) S,  A_ic := A_ic S,  A_cc := S^T A_cc S
//
// and (31) eliminates q', three numbers, like the twists of other bodies. Stops are ordinary terms.
#pragma once

#include "core/system/block_order.h"

namespace godobject {

/// Returns A S, in the columns of v.
inline SpatialMatrix along_axes(const SpatialMatrix& A, const BlockJoint& joint) noexcept {
  SpatialMatrix along = SpatialMatrix::zero();
  for (std::size_t k = 0; k < static_cast<std::size_t>(joint.num_axes); ++k) {
    const SpatialVector U = A * joint.s[k];
    along.wv.col[k] = U.w;
    along.vv.col[k] = U.v;
  }
  return along;
}
/// Returns S^T F, in v.
inline Column along_axes(const SpatialVector& F, const BlockJoint& joint) noexcept {
  Vec3 tau = Vec3::Zero();
  for (int k = 0; k < joint.num_axes; ++k) tau[k] = dot(joint.s[static_cast<std::size_t>(k)], F);
  return Column(tau);
}
/// Returns S^T A S, in vv; ones for missing axes.
inline SymmetricSpatialMatrix along_axes(const SymmetricSpatialMatrix& A, const BlockJoint& joint) noexcept {
  SymmetricSpatialMatrix along{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::identity()};
  for (std::size_t k = 0; k < static_cast<std::size_t>(joint.num_axes); ++k)
    along.vv.col[k] = along_axes(A * joint.s[k], joint);
  return along;
}
/// Returns S q'.
inline SpatialVector moved_along(const BlockJoint& joint, const Column& q_dot) noexcept {
  const Vec3 q = q_dot.vec();
  SpatialVector V = SpatialVector::zero();
  for (int k = 0; k < joint.num_axes; ++k) V = V + joint.s[static_cast<std::size_t>(k)] * q[k];
  return V;
}

}  // namespace godobject
