#include "hal/kinematic_chain.h"

#include <algorithm>

namespace godobject {

namespace {

// X_AC = X_AB X_BC
Pose compose(const Pose& X_AB, const Pose& X_BC) noexcept {
  return {X_AB.p + X_AB.q * X_BC.p, (X_AB.q * X_BC.q).normalized()};
}

Pose joint_motion(ChainJointKind kind, const Vec3& axis, Real q) noexcept {
  if (kind == ChainJointKind::slider) return {q * axis, Quat::Identity()};
  return {Vec3::Zero(), Quat(Eigen::AngleAxis<Real>(q, axis))};
}

}  // namespace

Twist ChainConfiguration::twist(const JointVector& q_dot) const noexcept {
  Twist V_WH;
  V_WH.w.noalias() = J.topRows<3>() * q_dot;
  V_WH.v.noalias() = J.bottomRows<3>() * q_dot;
  return V_WH;
}

JointVector ChainConfiguration::joint_torques(const Wrench& F_H_W) const noexcept {
  JointVector tau(J.cols());
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    tau(i) = J.col(i).head<3>().dot(F_H_W.tau) + J.col(i).tail<3>().dot(F_H_W.f);
  }
  return tau;
}

KinematicChain::KinematicChain(const ChainParams& chain) noexcept
    : X_WB_(chain.X_WB), num_joints_(std::min(chain.joints.size(), max_joints)), X_LH_(chain.X_LH) {
  for (std::size_t i = 0; i < num_joints_; ++i) {
    const ChainJoint& joint = chain.joints[i];
    joints_[i] = {joint.kind, joint.X_PJ, joint.axis_J};
  }
}

ChainConfiguration KinematicChain::at(const JointVector& q) const noexcept {
  std::array<Vec3, max_joints> axis_W;
  std::array<Vec3, max_joints> p_WJ;
  Pose X_WL = X_WB_;
  for (std::size_t i = 0; i < num_joints_; ++i) {
    const Joint& joint = joints_[i];
    const Pose X_WJ = compose(X_WL, joint.X_PJ);
    axis_W[i] = X_WJ.q * joint.axis_J;
    p_WJ[i] = X_WJ.p;
    X_WL = compose(X_WJ, joint_motion(joint.kind, joint.axis_J, q(static_cast<Eigen::Index>(i))));
  }

  ChainConfiguration out;
  out.X_WH = compose(X_WL, X_LH_);
  out.J.resize(6, static_cast<Eigen::Index>(num_joints_));
  for (std::size_t i = 0; i < num_joints_; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    // hinge: w = a, v = a x (p_WH - p_WJ);  slider: w = 0, v = a
    const bool hinge = joints_[i].kind == ChainJointKind::hinge;
    out.J.col(column).head<3>() = hinge ? axis_W[i] : Vec3(Vec3::Zero());
    out.J.col(column).tail<3>() = hinge ? Vec3(axis_W[i].cross(out.X_WH.p - p_WJ[i])) : axis_W[i];
  }
  return out;
}

}  // namespace godobject
