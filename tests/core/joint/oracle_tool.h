// A case of the oracle, run by the core.
#pragma once

#include "tests/oracle/target.h"
#include "tests/study/joint/oracle_joint.h"
#include "tests/study/joint/tool.h"

namespace godobject {

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
      in_.devices[i].target = to;
    }
    godobject::step(par_, in_, x_, w_, out_);
  }

  Params<S>& params() { return par_; }
  State<S>& state() { return x_; }
  const State<S>& state() const { return x_; }
  const Output<S>& output() const { return out_; }

  /// Worst violation of the joints, m and rad.
  Drift drift() const { return godobject::drift(par_, x_); }

 private:
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
