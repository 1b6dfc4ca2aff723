#include "hal/joint/kinematic_tree.h"

#include <algorithm>

namespace godobject {

namespace {

// X_AC = X_AB X_BC
Pose compose(const Pose& X_AB, const Pose& X_BC) noexcept {
  return {X_AB.p + X_AB.q * X_BC.p, (X_AB.q * X_BC.q).normalized()};
}

Pose joint_motion(DeviceJointKind kind, const Vec3& axis, Real q) noexcept {
  if (kind == DeviceJointKind::slider) return {q * axis, Quat::Identity()};
  return {Vec3::Zero(), Quat(Eigen::AngleAxis<Real>(q, axis))};
}

// Returns the joint's index plus 1; 0 if it does not exist.
std::size_t link_of(std::span<const DeviceJoint> joints, const std::string& name) noexcept {
  const auto found = std::ranges::find(joints, name, &DeviceJoint::name);
  return found == joints.end() ? 0 : static_cast<std::size_t>(found - joints.begin()) + 1;
}

}  // namespace

std::optional<std::size_t> parent_link(std::span<const DeviceJoint> joints, std::size_t index) noexcept {
  const std::string& parent = joints[index].parent;
  if (parent.empty()) return index;
  if (parent == base_name) return 0;
  const std::size_t link = link_of(joints.first(index), parent);
  if (link == 0) return std::nullopt;
  return link;
}

// hinge: w = a, v = a x (p_WH - p_WJ); slider: w = 0, v = a
Twist TreeConfiguration::column(std::size_t handle, std::size_t joint) const noexcept {
  const Joint& j = joints_[joint];
  if (!j.hinge) return {Vec3::Zero(), j.axis_W};
  return {j.axis_W, j.axis_W.cross(handles_[handle].X_WH.p - j.p_WJ)};
}

HandleJacobian TreeConfiguration::jacobian(std::size_t handle) const noexcept {
  HandleJacobian J = HandleJacobian::Zero(6, static_cast<Eigen::Index>(num_joints_));
  for (std::size_t j = 0; j < num_joints_; ++j) {
    if (!moves(j, handle)) continue;
    const Twist V = column(handle, j);
    J.col(static_cast<Eigen::Index>(j)) << V.w, V.v;
  }
  return J;
}

Twist TreeConfiguration::twist(std::size_t handle, const JointVector& q_dot) const noexcept {
  Twist V_WH;
  for (std::size_t j = 0; j < num_joints_; ++j) {
    if (!moves(j, handle)) continue;
    const Twist V = column(handle, j);
    V_WH.w += q_dot(static_cast<Eigen::Index>(j)) * V.w;
    V_WH.v += q_dot(static_cast<Eigen::Index>(j)) * V.v;
  }
  return V_WH;
}

JointVector TreeConfiguration::joint_torques(std::span<const Wrench> F_H_W) const noexcept {
  JointVector tau = JointVector::Zero(static_cast<Eigen::Index>(num_joints_));
  for (std::size_t i = 0; i < std::min(F_H_W.size(), num_handles_); ++i) {
    for (std::size_t j = 0; j < num_joints_; ++j) {
      if (!moves(j, i)) continue;
      const Twist V = column(i, j);
      tau(static_cast<Eigen::Index>(j)) += V.w.dot(F_H_W[i].tau) + V.v.dot(F_H_W[i].f);
    }
  }
  return tau;
}

// tau_j = dp/dq_j . M g with p the centre and M the mass of all that joint j moves
JointVector TreeConfiguration::weight_torques(const Vec3& g_W) const noexcept {
  JointVector tau = JointVector::Zero(static_cast<Eigen::Index>(num_joints_));
  for (std::size_t j = 0; j < num_joints_; ++j) {
    const Joint& joint = joints_[j];
    const Vec3 moment_W = joint.mp_W - joint.mass * joint.p_WJ;
    tau(static_cast<Eigen::Index>(j)) =
        joint.hinge ? joint.axis_W.dot(moment_W.cross(g_W)) : joint.mass * joint.axis_W.dot(g_W);
  }
  return tau;
}

KinematicTree::KinematicTree(const KinematicTreeParams& tree) noexcept
    : X_WB_(tree.X_WB),
      num_joints_(std::min(tree.joints.size(), max_joints)),
      num_handles_(std::min(tree.handles.size(), max_handles)) {
  const std::span joints = std::span(tree.joints).first(num_joints_);
  std::array<std::uint32_t, max_joints + 1> movers{};  // by link
  for (std::size_t j = 0; j < num_joints_; ++j) {
    const std::size_t parent = parent_link(joints, j).value_or(0);
    joints_[j] = {joints[j].kind, parent, joints[j].X_PJ, joints[j].axis_J, joints[j].mass, joints[j].p_LM};
    movers[j + 1] = movers[parent] | 1u << j;
  }
  for (std::size_t i = 0; i < num_handles_; ++i) {
    const std::size_t link = link_of(joints, tree.handles[i].joint);
    handles_[i] = {link, tree.handles[i].X_LH, movers[link]};
  }
}

TreeConfiguration KinematicTree::at(const JointVector& q) const noexcept {
  TreeConfiguration out;
  out.num_joints_ = num_joints_;
  out.num_handles_ = num_handles_;
  std::array<Pose, max_joints + 1> X_WL;
  X_WL[0] = X_WB_;
  for (std::size_t j = 0; j < num_joints_; ++j) {
    const Joint& joint = joints_[j];
    const Pose X_WJ = compose(X_WL[joint.parent_link], joint.X_PJ);
    X_WL[j + 1] = compose(X_WJ, joint_motion(joint.kind, joint.axis_J, q(static_cast<Eigen::Index>(j))));
    out.joints_[j] = {.axis_W = X_WJ.q * joint.axis_J,
                      .p_WJ = X_WJ.p,
                      .hinge = joint.kind == DeviceJointKind::hinge,
                      .mass = joint.mass,
                      .mp_W = joint.mass * (X_WL[j + 1].p + X_WL[j + 1].q * joint.p_LM)};
  }
  for (std::size_t j = num_joints_; j-- > 0;) {  // a parent comes before its children
    if (joints_[j].parent_link == 0) continue;
    auto& parent = out.joints_[joints_[j].parent_link - 1];
    parent.mass += out.joints_[j].mass;
    parent.mp_W += out.joints_[j].mp_W;
  }
  for (std::size_t i = 0; i < num_handles_; ++i) {
    out.handles_[i] = {compose(X_WL[handles_[i].link], handles_[i].X_LH), handles_[i].movers};
  }
  return out;
}

}  // namespace godobject
