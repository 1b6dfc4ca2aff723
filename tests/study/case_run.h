// Runs a case of the oracle as a scene of the core, with equal numbers.
#pragma once

#include <vector>

#include "tests/oracle/target.h"
#include "tests/study/joint/oracle_joint.h"
#include "tests/study/joint/tool.h"

namespace godobject::study {

inline Target target_of(const oracle::RigidState& D) {
  return {.X_WD = {.p = D.p, .q = Quat(D.q)}, .V_WD = {.w = D.w, .v = D.v}};
}

/// Sets the device input at the end of a step in which the target moved from D_0 to D_1.
inline void set_input(const oracle::RigidState&, const oracle::RigidState& D_1, PoseDevice::Input& in) {
  in = {.target = target_of(D_1)};
}
inline void set_input(const oracle::RigidState& D_0, const oracle::RigidState& D_1,
                      RelativeDevice::Input& in) {
  const Eigen::AngleAxisd turn(D_1.q * D_0.q.conjugate());
  in = {.dp_W = D_1.p - D_0.p, .dphi_W = turn.angle() * turn.axis()};
}
/// A case has no hand: the force is 10 N per metre, about 1 N in S1.
inline void set_input(const oracle::RigidState&, const oracle::RigidState& D_1, AdmittanceDevice::Input& in) {
  in = {.F_WB = {.tau = Vec3::Zero(), .f = 10 * D_1.p}};
}

/// Returns a case with n copies of its one body, without joints.
inline oracle::Case copies(oracle::Case problem, std::size_t n) {
  problem.bodies.assign(n, problem.bodies.front());
  return problem;
}

/// A running scene with the bodies of a case, parents before children. Coupled bodies are engaged from the
/// start without ramp; bodies without a coupling are disengaged. Feedback gains equal the coupling's.
template <Scene S>
class CaseRun {
 public:
  /// problem: must outlive this.
  CaseRun(const oracle::Case& problem, double h) : problem_(problem) {
    par_.h = h;
    par_.num_bodies = problem.bodies.size();
    par_.gravity_W = problem.gravity;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) set_body(problem.bodies[i], par_.bodies[i]);
    if constexpr (uses<typename S::Joints>)
      for (const oracle::Joint& joint : problem.joints)
        static_cast<JointParams&>(par_.bodies[joint.child].joint) = joint_params(joint);
    restart();
  }

  void restart() {
    x_ = State<S>{};
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const oracle::Body& body = problem_.bodies[i];
      place(x_, i,
            {.X_WB = {.p = body.start.p, .q = Quat(body.start.q)},
             .V_WB = {.w = body.start.w, .v = body.start.v}});
      if constexpr (uses<typename S::Device>)
        if (body.coupling) engage_at(x_, i, target_of(body.coupling->target->at(0)));
    }
  }

  /// Returns the inputs of `steps` steps after the `first` ones. t_last: latest time at which the target is
  /// evaluated, s.
  std::vector<Input<S>> inputs(std::size_t steps, double t_last, std::size_t first = 0) const {
    std::vector<Input<S>> all(steps);
    if constexpr (uses<typename S::Device>) {
      for (std::size_t i = 0; i < par_.num_bodies; ++i) {
        if (!problem_.bodies[i].coupling) {
          for (Input<S>& in : all) in.devices[i].engaged = false;
          continue;
        }
        const oracle::Target& target = *problem_.bodies[i].coupling->target;
        const auto at_tick = [&](std::size_t n) {
          return target.at(std::min(static_cast<double>(n) * par_.h, t_last));
        };
        oracle::RigidState D = at_tick(first);
        for (std::size_t n = 0; n < steps; ++n) {
          const oracle::RigidState D_next = at_tick(first + n + 1);
          set_input(D, D_next, all[n].devices[i]);
          D = D_next;
        }
      }
    }
    return all;
  }

  void step(const Input<S>& in) noexcept { godobject::step(par_, in, x_, w_, out_); }

  Params<S>& params() { return par_; }
  State<S>& state() { return x_; }
  Scratch<S>& scratch() { return w_; }
  Output<S>& output() { return out_; }
  const RigidBodyState& body(std::size_t i) const { return x_.bodies[i].x; }
  Real kinetic() const {
    Real sum = 0;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) sum += kinetic_energy(par_.bodies[i].body, body(i));
    return sum;
  }
  /// Returns the drift; zero without joints.
  Drift drift() const {
    if constexpr (uses<typename S::Joints>) return godobject::drift(par_, x_);
    return {};
  }

 private:
  static void set_body(const oracle::Body& body, BodyParams<S>& par) {
    par.body = rigid_body(body.m, body.I_B);
    if constexpr (uses<typename S::Coupling>) {
      const oracle::Coupling c = body.coupling.value_or(oracle::Coupling{});
      par.coupling = {.k = c.k_t, .g = c.g_t, .k_r = c.k_r, .g_r = c.g_r};
    }
    if constexpr (uses<typename S::Feedback>) par.feedback.gains = par.coupling;
    if constexpr (uses<typename S::Device>) par.device.rise = 0;
  }

  const oracle::Case& problem_;
  Params<S> par_;
  State<S> x_;
  Scratch<S> w_;
  Output<S> out_;
};

}  // namespace godobject::study
