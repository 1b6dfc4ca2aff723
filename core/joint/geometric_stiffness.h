// Geometric stiffness: the effect on a stage of forces and torques whose levers rotate with the bodies.
//
// A large constraint force on a light body acts as a stiff spring (a taut rope oscillates fast), however soft
// the springs are. Without it, light bodies between strong forces oscillate for ever, such as those of a tool
// whose targets contradict its joints. It enters as K (w+ - w^), w^ the linearisation point. That force is of
// the order of the acceleration and of h^2, so the integrators keep their order. K has no negative part:
// motions that it would drive apart need no stabilisation.
#pragma once

#include <limits>

#include "core/joint/joint.h"
#include "core/math/spatial.h"
#include "core/tuning.h"

namespace godobject {

/// Returns the restoring part of the stiffness of a force F at the end of a lever d (21). Its torque is d x
/// F; as the lever rotates, the torque changes by K w. With a = |F|, b = |d|, s = F . d and the eigenvectors
/// F/a + d/b, F/a - d/b and F x d,
///
///   K = (a b + s) 1 / 2 - (b F + a d)(b F + a d)^T / (4 a b) - (F x d)(F x d)^T / (2 (a b + |s|))
template <class T>
Matrix3<T> lever_stiffness(const Vector3<T>& d, const Vector3<T>& F) noexcept {
  using std::abs;
  using std::max;
  using std::sqrt;
  constexpr Real tiny = std::numeric_limits<Real>::min();
  const T a = sqrt(F.squaredNorm()), b = sqrt(d.squaredNorm()), s = F.dot(d), ab = a * b;
  const Vector3<T> u = F * b + d * a, n = F.cross(d);
  const Vector3<T> u_s = u * (T(0.25) / max(ab, T(tiny))), n_s = n * (T(0.5) / max(ab + abs(s), T(tiny)));
  Matrix3<T> K = -(u_s * u.transpose() + n_s * n.transpose());
  K.diagonal().array() += T(0.5) * (ab + s);
  return K;
}

/// Returns the skew part of that stiffness, in axes that turn with the body. It does no work on w+ - w^. At
/// rest it cancels the same part of the torques (11) that balance F.
///
///   K_skew = -[d x F]x / 2
template <class T>
Matrix3<T> lever_skew(const Vector3<T>& d, const Vector3<T>& F) noexcept {
  return skew<T>(F.cross(d) * T(Real(0.5)));
}

/// Returns the stiffness (21) of the component of F along d alone, if it pulls: s (1 - d d^T / b^2).
inline Block pull_stiffness(const Column& d, const Vec3& F) noexcept {
  const Real pull = std::max(dot(d, Column(F)), Real(0));
  const Column sd = d * (pull / std::max(dot(d, d), std::numeric_limits<Real>::min()));
  return Block::identity() * dot(sd, d) - outer(sd, d);
}

/// Returns the mean of the diagonal of a block of an A.
inline Real mean_of(const Block& A) noexcept { return (A.col[0].x() + A.col[1].y() + A.col[2].z()) / 3; }

inline Block block_of(const Mat3& A) noexcept {
  return {{Column(Vec3(A.col(0))), Column(Vec3(A.col(1))), Column(Vec3(A.col(2)))}};
}

/// Adds the stiffness (21) of a force F at r from the centre of rotation to a body's A and b, times h^2.
/// w: predicted angular velocity. is_whole: include the skew part, which a symmetric A cannot contain.
template <bool is_whole, class T>
void stiffen(const Vector3<T>& r, const Vector3<T>& F, const Vector3<T>& w, Matrix3<T>& A,
             Vector3<T>& b) noexcept {
  const T min_stiffness = min_stiffness_share * A.trace() * T(Real(1) / 3);
  if (!any(min_stiffness * min_stiffness < F.squaredNorm() * r.squaredNorm())) return;
  Matrix3<T> K = lever_stiffness<T>(r, F);
  if constexpr (is_whole) K += lever_skew<T>(r, F);
  A += K;
  b += K * w;
}

/// Stiffness that a joint adds to A of its bodies, for rotations of the parent and of the child, and for its
/// slide. The stiffness of the slide leaves the momentum of both bodies unchanged.
struct JointStiffness {
  Block parent = Block::zero();
  Real turn = 0, slide = 0;
  bool is_stiff = false;  // true if the neglected part may reverse the rotation of a body within a stage
};

/// Returns the stiffness of a joint.
/// d: lever from the parent's anchor to the child's. r: from the child's anchor to its centre of mass. A_ww:
/// rotational block of either body. M: the child's mass and coupling. F_C: wrench of the joint on the child.
///
/// Axes of the joint turn with the parent (40). A torque tau across them couples rotations of both bodies by
/// at most |tau| / 2. A force f across a slide couples its rate and the parent's rotation by |f|. Both enter
/// as bounds on the diagonal.
template <class Motion>
[[gnu::noinline]] JointStiffness joint_stiffness(const Column& d, const Vec3& r, const Wrench& F_C, Real h,
                                                 Real A_parent, Real A_child, Real M) noexcept {
  constexpr int turns = Motion::num_turns, slides = Motion::num_slides;
  const Vec3 d_W = d.vec(), f = h * h * F_C.f;
  const Real size = f.norm();
  JointStiffness K{.parent = block_of(lever_stiffness<Real>(d_W, -f))};
  Real of_parent = 0;
  if constexpr (turns == 1 || turns == 2) of_parent = K.turn = h * h * F_C.tau.norm() / 2;
  if constexpr (slides > 0) {
    const Real lever = std::sqrt(A_child / M);
    K.slide = size / (2 * lever);
    of_parent += size * lever / 2;
  }
  K.parent += Block::identity() * of_parent;
  const auto left_out = [&](const Vec3& lever) noexcept {
    return (size * lever.norm() - std::abs(f.dot(lever))) / 2;
  };
  K.is_stiff = left_out(d_W) + of_parent > stiff_joint_share * A_parent ||
               std::max(left_out(r), K.turn) > stiff_joint_share * A_child;
  return K;
}

/// True if the stiffness is significant against A of either body.
inline bool is_significant(const Column& d, const Vec3& r, const Wrench& F_C, Real h, Real A_parent,
                           Real A_child) noexcept {
  const Real A = min_stiffness_share * std::min(A_parent, A_child), hh = h * h;
  return hh * hh *
             std::max(F_C.f.squaredNorm() * std::max(dot(d, d), r.squaredNorm()), F_C.tau.squaredNorm()) >
         A * A;
}

/// Body of a joint in its stage, about its anchor or centre of mass. Mass: a number, or a block.
template <class Mass>
struct StiffenedBody {
  Block& A_ww;
  Mass& A_vv;
  SpatialVector& b;
  const Twist& V;  // predicted
};
inline Real mean_of(Real M) noexcept { return M; }

/// Adds the stiffness (21), (40) to the stages of a joint's bodies: to A, and to b its product with the
/// predicted velocities. has_parent: the parent is a body, not the world. Returns the effective mass added to
/// the coordinate of a slide, kg.
template <class Motion, class Mass>
[[nodiscard]] Real stiffen(const Column& lever, const Vec3& r, const Wrench& F_C, Real h, bool has_parent,
                           const StiffenedBody<Mass>& parent, const StiffenedBody<Mass>& child,
                           bool& is_stiff) noexcept {
  const Column d = has_parent ? lever : Column(Pack(0));
  const Real A_child = mean_of(child.A_ww),
             A_parent = has_parent ? mean_of(parent.A_ww) : std::numeric_limits<Real>::max();
  if (!is_significant(d, r, F_C, h, A_parent, A_child)) return 0;
  const JointStiffness K = joint_stiffness<Motion>(d, r, F_C, h, A_parent, A_child, mean_of(child.A_vv));
  is_stiff |= K.is_stiff;
  child.A_ww += Block::identity() * K.turn;
  child.b.w += Column(child.V.w) * K.turn;
  if (!has_parent) return K.slide;
  parent.A_ww += K.parent;
  parent.b.w += K.parent * Column(parent.V.w);
  return K.slide;
}

}  // namespace godobject
