#include "hal/joint/inverse_kinematics.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"

namespace godobject {

namespace {

using Vec6 = Eigen::Matrix<Real, 6, 1>;
using Mat6 = Eigen::Matrix<Real, 6, 6>;

constexpr std::size_t joints_needed = 6;
constexpr int max_iterations = 100;
constexpr double tolerance = 1e-12;  // m, and rad times lever_m: far below one encoder count
constexpr double lever_m = 0.1;      // length that weights an attitude error of 1 rad
constexpr double min_damping = 1e-15, max_damping = 1e6;
constexpr double min_reciprocal_condition = 1e-6;
constexpr double max_turn_rad = 0.5;  // per iteration and joint, so that a step stays on its branch

// Returns log q for the shorter rotation, angle in [0, pi].
Vec3 rotation_vector(const Quat& q) noexcept {
  const Real sign = q.w() < 0 ? Real(-1) : Real(1);
  return sign * log_factor(sign * q.w()) * q.vec();
}

// Returns e = [lever * rotation vector of q_WD q_WH^-1; p_WD - p_WH], world axes.
Vec6 pose_error(const Pose& X_WD, const Pose& X_WH) noexcept {
  Vec6 e;
  e.head<3>() = lever_m * rotation_vector(X_WD.q * X_WH.q.conjugate());
  e.tail<3>() = X_WD.p - X_WH.p;
  return e;
}

Mat6 weighted_jacobian(const TreeConfiguration& configuration) noexcept {
  Mat6 J = configuration.jacobian(0);
  J.topRows<3>() *= lever_m;
  return J;
}

bool is_singular(const Mat6& J) noexcept {
  return !(Eigen::PartialPivLU<Mat6>(J).rcond() > min_reciprocal_condition);
}

// Solves (J^T J + lambda I) dq = J^T e.
Vec6 levenberg_step(const Mat6& J, const Vec6& e, double damping) noexcept {
  Mat6 A = J.transpose() * J;
  A.diagonal().array() += damping;
  const Vec6 dq = A.llt().solve(J.transpose() * e);
  return dq * std::min(1.0, max_turn_rad / std::max(dq.cwiseAbs().maxCoeff(), max_turn_rad));
}

}  // namespace

InverseKinematics::InverseKinematics(const KinematicTreeParams& tree) noexcept
    : tree_(tree), q_(JointVector::Zero(static_cast<Eigen::Index>(tree_.num_joints()))) {}

bool InverseKinematics::invertible() const noexcept {
  if (tree_.num_handles() != 1 || tree_.num_joints() != joints_needed) return false;
  for (std::size_t joint = 0; joint < joints_needed; ++joint)
    if (!tree_.moves(joint, 0)) return false;
  return true;
}

IkSolution InverseKinematics::solve(const Pose& X_WH) noexcept {
  IkSolution out;
  out.q = q_;
  if (!invertible() || !X_WH.p.allFinite() || !X_WH.q.coeffs().allFinite()) return out;

  TreeConfiguration configuration = tree_.at(out.q);
  Vec6 e = pose_error(X_WH, configuration.X_WH(0));
  double damping = min_damping;
  while (!(e.norm() <= tolerance) && out.iterations < max_iterations && damping <= max_damping) {
    ++out.iterations;
    const JointVector q_next = out.q + levenberg_step(weighted_jacobian(configuration), e, damping);
    const TreeConfiguration next = tree_.at(q_next);
    const Vec6 e_next = pose_error(X_WH, next.X_WH(0));
    if (e_next.norm() < e.norm()) {
      out.q = q_next;
      configuration = next;
      e = e_next;
      damping = std::max(damping * 1e-2, min_damping);
    } else {
      damping = std::max(damping * 1e2, 1e-9);
    }
  }
  out.residual_m = e.tail<3>().norm();
  out.residual_rad = e.head<3>().norm() / lever_m;
  if (!(e.norm() <= tolerance)) {
    out.status = IkStatus::unreachable;
    return out;
  }
  out.status = is_singular(weighted_jacobian(configuration)) ? IkStatus::singular : IkStatus::solved;
  q_ = out.q;
  return out;
}

bool InverseKinematics::joint_rates(const Twist& V_WH, JointVector& q_dot) const noexcept {
  q_dot.setZero(q_.size());
  if (!invertible()) return false;
  const Mat6 J = weighted_jacobian(tree_.at(q_));
  if (is_singular(J)) return false;
  Vec6 V;
  V << lever_m * V_WH.w, V_WH.v;
  q_dot = J.partialPivLu().solve(V);
  return true;
}

}  // namespace godobject
