// A case of the oracle, run by the core.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/godobject.h"
#include "tests/oracle/case.h"
#include "tests/oracle/target.h"

namespace godobject {

template <class I>
struct Articulated {
  static constexpr std::size_t max_bodies = 8;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = None;
};

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

/// The oracle's joint in the core's frames: z is the axis of hinge, slider and cylindrical joint; x of the parent's
/// and y of the child's frame are those of the universal joint.
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
    axes.setFromTwoVectors(Vec3::UnitZ(), joint.axis_P);
  }
  const Eigen::Quaterniond on_child = joint.q_PC.conjugate() * axes;
  par.P = {.p = joint.anchor_P, .R = axes.toRotationMatrix()};
  par.C = {.p = joint.anchor_C, .R = on_child.toRotationMatrix()};
  return par;
}

/// Runs a case with parents before children at a fixed step.
template <class I>
class OracleTool {
 public:
  using S = Articulated<I>;

  OracleTool(const oracle::Case& problem, double h) : problem_(problem) {
    par_.h = h;
    par_.num_bodies = problem.bodies.size();
    par_.gravity_W = problem.gravity;
    for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
      const oracle::Body& body = problem.bodies[i];
      par_.bodies[i].body = rigid_body(body.m, body.I_B);
      par_.bodies[i].device.rise = 0;
      if (body.coupling)
        par_.bodies[i].coupling = {body.coupling->k_t, body.coupling->g_t, body.coupling->k_r,
                                   body.coupling->g_r};
      const Quat q(body.start.q.w(), body.start.q.x(), body.start.q.y(), body.start.q.z());
      place(x_, i, {.X_WB = {body.start.p, q}, .V_WB = {body.start.w, body.start.v}});
      engage_at(x_, i, target(i, 0));
    }
    for (const oracle::Joint& joint : problem.joints)
      static_cast<JointParams&>(par_.bodies[joint.child].joint) = joint_params(joint);
  }

  void step() {
    const double t = static_cast<double>(++tick_) * par_.h;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const Target to = target(i, t);
      in_.devices[i].X_WD = to.X_WD;
      in_.devices[i].V_WD = to.V_WD;
    }
    godobject::step(par_, in_, x_, w_, out_);
  }

  Params<S>& params() { return par_; }
  State<S>& state() { return x_; }
  const State<S>& state() const { return x_; }
  const Output<S>& output() const { return out_; }

  /// Worst violation of the joints, m and rad.
  std::pair<double, double> drift() const {
    double m = 0, rad = 0;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const JointParams& joint = par_.bodies[i].joint;
      const JointFrames X = joint_at(joint, place_of(joint.parent), place_of(i)).X;
      with_joint(joint.kind, [&](auto kind) {
        const auto motion = kind.motion(X);
        m = std::max(m, motion.e_v.norm());
        rad = std::max(rad, motion.e_w.norm());
      });
    }
    return {m, rad};
  }

 private:
  TreePlace place_of(std::size_t i) const {
    return i == world ? TreePlace{} : place(par_.bodies[i].joint.C.p, x_.bodies[i].x);
  }
  Target target(std::size_t i, double t) const {
    const oracle::Body& body = problem_.bodies[i];
    if (!body.coupling) return {.X_WD = x_.bodies[i].x.X_WB, .V_WD = {}};
    const oracle::RigidState s = body.coupling->target->at(t);
    return {.X_WD = {s.p, Quat(s.q.w(), s.q.x(), s.q.y(), s.q.z()).normalized()}, .V_WD = {s.w, s.v}};
  }

  const oracle::Case& problem_;
  Params<S> par_;
  State<S> x_;
  Scratch<S> w_;
  Input<S> in_;
  Output<S> out_;
  long tick_ = 0;
};

}  // namespace godobject
