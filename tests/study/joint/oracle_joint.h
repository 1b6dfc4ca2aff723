// Converts joints of a case of the oracle to those of the core.
#pragma once

#include "core/joint/list.h"
#include "core/math/so3.h"
#include "tests/oracle/case/case.h"

namespace godobject {

/// Returns the kind in the core.
inline JointKind kind_of(oracle::JointType type) {
  switch (type) {
    case oracle::JointType::fixed: return JointKind::fixed;
    case oracle::JointType::ball: return JointKind::ball;
    case oracle::JointType::hinge: return JointKind::hinge;
    case oracle::JointType::slider: return JointKind::slider;
    case oracle::JointType::cylindrical: return JointKind::cylindrical;
    case oracle::JointType::universal: return JointKind::universal;
  }
  return JointKind::free;
}

/// Converts the oracle's joint to the core's frames: z is the axis of hinge, slider and cylindrical joint.
/// The axes of the universal joint are x of the parent's and y of the child's frame.
inline JointParams joint_params(const oracle::Joint& joint) {
  JointParams par;
  par.kind = kind_of(joint.type);
  par.parent = joint.parent ? *joint.parent : world;
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();
  if (par.kind == JointKind::universal) {
    Eigen::Matrix3d R;
    R.col(0) = joint.axis_P;
    R.col(1) = joint.axis_C;  // at coordinate zero both bodies have the attitude q_PC = 1
    R.col(2) = joint.axis_P.cross(joint.axis_C);
    axes = Eigen::Quaterniond(R);
  } else {
    axes = turn_from_z(joint.axis_P);
  }
  const Eigen::Quaterniond on_child = joint.q_PC.conjugate() * axes;
  par.P = {.p = joint.anchor_P, .R = axes.toRotationMatrix()};
  par.C = {.p = joint.anchor_C, .R = on_child.toRotationMatrix()};
  return par;
}

}  // namespace godobject
