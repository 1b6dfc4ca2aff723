// Geometric stiffness: what forces and torques do to a stage because the bodies turn on which they act.
//
// A joint that bears much against a small inertia is stiff, however soft all springs are: a rope under load swings
// fast. What is left explicit of it makes light bodies between strong forces swing for ever, such as those of a tool
// whose targets contradict its joints. It is taken as K (w+ - w^), w^ what the stage is linearised for: a force of the
// order of the acceleration and of h^2, so the integrators keep their order. K has no negative part: what that drives
// apart, the motion does by itself.
#pragma once

#include <limits>

#include "core/joint/joint.h"
#include "core/math/spatial.h"
#include "core/tuning.h"

namespace godobject {

/// (21)  A force F at the end of a lever d does d x F. As the lever turns that changes by K w, of which this is the
/// part that pulls back. With a = |F|, b = |d|, s = F . d and the eigenvectors F/a + d/b, F/a - d/b and F x d,
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

/// The rest of that stiffness which is not symmetric, in axes that turn with the body. It does no work on w+ - w^; at rest it is what
/// cancels the same part of the torques (11) that hold against F.
///
///   K_skew = -[d x F]x / 2
template <class T>
Matrix3<T> lever_skew(const Vector3<T>& d, const Vector3<T>& F) noexcept {
  return skew<T>(F.cross(d) * T(Real(0.5)));
}

/// (21) of the part of F along d alone, where it pulls: s (1 - d d^T / b^2).
inline Block pull_stiffness(const Column& d, const Vec3& F) noexcept {
  const Real pull = std::max(dot(d, Column(F)), Real(0));
  const Column sd = d * (pull / std::max(dot(d, d), std::numeric_limits<Real>::min()));
  return Block::identity() * dot(sd, d) - outer(sd, d);
}

/// The mean of the diagonal of a block of an A.
inline Real mean_of(const Block& A) noexcept { return (A.col[0].x() + A.col[1].y() + A.col[2].z()) / 3; }

inline Block block_of(const Mat3& A) noexcept {
  return {{Column(Vec3(A.col(0))), Column(Vec3(A.col(1))), Column(Vec3(A.col(2)))}};
}

/// (21) of a force F at r from what a body turns about, into its A and b; h^2 F. w: its predicted angular velocity.
/// is_whole: with its skew part, which an A that is to be symmetric cannot take.
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

/// What a joint adds to the A of the stages of its bodies: K of any turn of the parent, so much of any turn of the child, and of
/// the rate of its slide, which leaves the momentum of both as it is.
struct JointStiffness {
  Block parent = Block::zero();
  Real turn = 0, slide = 0;
  bool is_stiff = false;  // the part that is left out may turn a body round within a stage
};

/// Its lever d from the parent's anchor to the child's and r from the child's anchor to its centre of mass; A_ww of
/// either body, and the child's mass and coupling M. F_C: of the joint on the child.
///
/// (40)  Axes of the joint turn with the parent, so that a torque tau across them couples turns of both bodies by no
/// more than |tau| / 2, and a force f across a slide its rate and the parent's turns by |f|. Both are taken as what
/// bounds them on the diagonal.
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

/// Whether a stage feels it: not where it is small against what bears it, A of either body.
inline bool is_significant(const Column& d, const Vec3& r, const Wrench& F_C, Real h, Real A_parent,
                           Real A_child) noexcept {
  const Real A = min_stiffness_share * std::min(A_parent, A_child), hh = h * h;
  return hh * hh *
             std::max(F_C.f.squaredNorm() * std::max(dot(d, d), r.squaredNorm()), F_C.tau.squaredNorm()) >
         A * A;
}

/// A body of a joint in its stage, about its anchor or centre of mass. Mass: a number, or a block.
template <class Mass>
struct StiffenedBody {
  Block& A_ww;
  Mass& A_vv;
  SpatialVector& b;
  const Twist& V;  // predicted
};
inline Real mean_of(Real M) noexcept { return M; }

/// (21), (40)  Into the stages of a joint's bodies: A is that much more than it would be, and b as much as that where the
/// velocities are those predicted. has_parent: on a parent, not on the world. Returns the effective mass that a slide's
/// coordinate gets likewise, kg.
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
