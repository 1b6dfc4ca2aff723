// A case of the oracle as a scene of the core: the same numbers given to both.
#pragma once

#include <vector>

#include "core/godobject.h"
#include "tests/oracle/case.h"
#include "tests/oracle/target.h"

namespace godobject::study {

inline Target target_of(const oracle::RigidState& D) {
  return {.X_WD = {.p = D.p, .q = Quat(D.q)}, .V_WD = {.w = D.w, .v = D.v}};
}

/// What the devices say at the end of a step in which the target moved from D_0 to D_1.
inline void set_input(const oracle::RigidState&, const oracle::RigidState& D_1, PoseDevice::Input& in) {
  const Target target = target_of(D_1);
  in = {.X_WD = target.X_WD, .V_WD = target.V_WD};
}
inline void set_input(const oracle::RigidState& D_0, const oracle::RigidState& D_1,
                      RelativeDevice::Input& in) {
  const Eigen::AngleAxisd turn(D_1.q * D_0.q.conjugate());
  in = {.dp_W = D_1.p - D_0.p, .dphi_W = turn.angle() * turn.axis()};
}
/// There is no hand in a case: 10 N per metre, which for S1 is about 1 N.
inline void set_input(const oracle::RigidState&, const oracle::RigidState& D_1, AdmittanceDevice::Input& in) {
  in = {.F_WB = {.tau = Vec3::Zero(), .f = 10 * D_1.p}};
}

/// One running scene whose bodies are `num_bodies` copies of the case's first body, engaged from the start
/// with no ramp. Feedback gains equal the coupling's.
template <Scene S>
class CaseRun {
 public:
  CaseRun(const oracle::Case& problem, double h, std::size_t num_bodies = 1) : problem_(problem) {
    par_.h = h;
    par_.num_bodies = num_bodies;
    par_.gravity_W = problem.gravity;
    for (std::size_t i = 0; i < num_bodies; ++i) set_body(problem.bodies.front(), par_.bodies[i]);
    restart();
  }

  void restart() {
    x_ = State<S>{};
    const oracle::Body& body = problem_.bodies.front();
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      place(x_, i,
            {.X_WB = {.p = body.start.p, .q = Quat(body.start.q)},
             .V_WB = {.w = body.start.w, .v = body.start.v}});
      if constexpr (uses<typename S::Device>) engage_at(x_, i, target_of(body.coupling->target->at(0)));
    }
  }

  /// The inputs of `steps` steps from t = 0, the target read no later than t_last.
  std::vector<Input<S>> inputs(std::size_t steps, double t_last) const {
    std::vector<Input<S>> all(steps);
    if constexpr (uses<typename S::Device>) {
      const oracle::Target& target = *problem_.bodies.front().coupling->target;
      oracle::RigidState D = target.at(0);
      for (std::size_t n = 0; n < steps; ++n) {
        const oracle::RigidState D_next = target.at(std::min(static_cast<double>(n + 1) * par_.h, t_last));
        for (std::size_t i = 0; i < par_.num_bodies; ++i) set_input(D, D_next, all[n].devices[i]);
        D = D_next;
      }
    }
    return all;
  }

  void step(const Input<S>& in) noexcept { godobject::step(par_, in, x_, w_, out_); }

  const Params<S>& params() const { return par_; }
  State<S>& state() { return x_; }
  Scratch<S>& scratch() { return w_; }
  Output<S>& output() { return out_; }
  const RigidBodyState& body() const { return x_.bodies[0].x; }
  Real kinetic() const { return kinetic_energy(par_.bodies[0].body, body()); }

 private:
  static void set_body(const oracle::Body& body, BodyParams<S>& par) {
    par.body = rigid_body(body.m, body.I_B);
    if constexpr (uses<typename S::Coupling>) {
      const oracle::Coupling& c = *body.coupling;
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
