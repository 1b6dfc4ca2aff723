// Joints as edges of the tree of bodies that touch: either of the two bodies may be the child there.
//
// Unknowns are the twists of bodies about their centres of mass, less some that obey the joints
// (core/contact/jointed_bodies.h). So, with S what the joint allows and e what a stop's force on a coordinate does to
// the child,
//
//   (30)  V_c = X V_p + S q',  U = A_c S,  D = S^T U + D_stop
//         A_p += X^T (A_c - U D^-1 U^T) X,  b_p += X^T (b_c - U D^-1 S^T b_c),  q' = D^-1 (S^T b_c - U^T X V_p)
//
// one axis of S after the other. Solutions, and so all directions of an iteration that is preconditioned by the tree,
// obey the joints exactly, and what is left unbalanced across S is what the joints bear.
#pragma once

#include <array>

#include "core/joint/list.h"
#include "core/math/spatial.h"

namespace godobject {

/// The joint of a body where a stage is predicted to end. Scratch: undefined between steps.
struct JointEdge {
  JointKind kind{};
  std::size_t parent = world;
  Column a_W;  // anchor, on the body
  int num_turns = 0, num_axes = 0;
  std::array<Column, 3> s;                 // axes, unit: turns, then slides
  std::array<Real, 2> stop_D{}, stop_b{};  // on the coordinates: impedance, and impulse at rest

  bool on_world() const noexcept { return kind != JointKind::free && parent == world; }
  bool on_body() const noexcept { return parent != world; }
};

/// Twist at p of a turn about, or a slide along, axis k.
inline AnchorTwist axis_twist(const JointEdge& edge, int k, const Column& p) noexcept {
  const Column& s = edge.s[static_cast<std::size_t>(k)];
  if (k >= edge.num_turns) return {.w = Column(Pack(0)), .v = s};
  return {.w = s, .v = cross(s, p - edge.a_W)};
}
/// Wrench about p of a torque about, or a force along, axis k.
inline AnchorTwist axis_wrench(const JointEdge& edge, int k, const Column& p) noexcept {
  const Column& s = edge.s[static_cast<std::size_t>(k)];
  if (k < edge.num_turns) return {.w = s, .v = Column(Pack(0))};
  return {.w = cross(edge.a_W - p, s), .v = s};
}

/// An axis of a joint, eliminated from the child.
struct EliminatedTwist {
  AnchorTwist s, U;  // (30)
  Real D_inverse = 0;
};

/// Of all bodies, by the body whose joint it is, or that is the child in the tree.
template <std::size_t N>
struct JointEdges {
  std::array<JointEdge, N> edges;
  std::array<bool, N> joined;                          // on a joint, or something hangs on it by one
  std::array<Column, N> p;                             // centres of mass
  std::array<std::array<EliminatedTwist, 3>, N> axes;  // of the joint by which a body hangs in the tree
  std::array<AnchorTwist, N> V_p;                      // twists that obey the joints
};

/// (30)  The axes of a joint out of a child at p; A: of the child and all that hangs on it.
inline void eliminate_axes(const JointEdge& edge, const Column& p, TwistBlock& A,
                           std::array<EliminatedTwist, 3>& axes) noexcept {
  for (int k = 0; k < edge.num_axes; ++k) {
    EliminatedTwist& j = axes[static_cast<std::size_t>(k)];
    j.s = axis_twist(edge, k, p);
    j.U = A * j.s;
    j.D_inverse = 1 / (dot(j.s, j.U) + (k < 2 ? edge.stop_D[static_cast<std::size_t>(k)] : 0));
    const AnchorTwist P = j.U * j.D_inverse;
    A.ww -= outer(P.w, j.U.w);
    A.wv -= outer(P.w, j.U.v);
    A.vv -= outer(P.v, j.U.v);
  }
}

/// (30)  The same of b. Returns S^T b.
inline Vec3 eliminate_axes(int num_axes, const std::array<EliminatedTwist, 3>& axes,
                           AnchorTwist& b) noexcept {
  Vec3 tau = Vec3::Zero();
  for (int k = 0; k < num_axes; ++k) {
    const EliminatedTwist& j = axes[static_cast<std::size_t>(k)];
    tau[k] = dot(j.s, b);
    b = b - j.U * (tau[k] * j.D_inverse);
  }
  return tau;
}

/// (30)  The twist of a child from that of its parent, shifted to it.
inline AnchorTwist solve_axes(int num_axes, const std::array<EliminatedTwist, 3>& axes, const Vec3& tau,
                              AnchorTwist V) noexcept {
  for (int k = num_axes; k-- > 0;) {
    const EliminatedTwist& j = axes[static_cast<std::size_t>(k)];
    V = V + j.s * ((tau[k] - dot(j.U, V)) * j.D_inverse);
  }
  return V;
}

}  // namespace godobject
