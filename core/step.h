// The time step. Equation numbers are those of docs/step.md.
#pragma once

#include "core/device/feedback.h"
#include "core/energy_rise.h"
#include "core/math/flatten.h"
#include "core/net_momentum.h"
#include "core/nonblocking.h"
#include "core/stage.h"

namespace godobject {

inline bool is_finite(Real sum) noexcept { return sum - sum == 0; }  // false for NaN and infinity
inline bool is_finite(const Pack& sum) noexcept {
  return is_finite((lane(sum, 0) + lane(sum, 1)) + (lane(sum, 2) + lane(sum, 3)));
}

template <class T>
T sum(const PoseOf<T>& X) noexcept {
  return X.p.sum() + X.q.coeffs().sum();
}
inline Real sum(const Twist& V) noexcept { return V.w.sum() + V.v.sum(); }
inline Real sum(const Wrench& F) noexcept { return F.tau.sum() + F.f.sum(); }

inline Fault check(const PoseDevice::Input& in) noexcept {
  if (!in.valid) return Fault::none;
  if (!is_finite(sum(in.target.X_WD) + sum(in.target.V_WD))) return Fault::input_not_finite;
  return std::abs(in.target.X_WD.q.squaredNorm() - 1) <= 2 * quaternion_tolerance ? Fault::none
                                                                                  : Fault::input_not_unit;
}
inline Fault check(const RelativeDevice::Input& in) noexcept {
  if (!in.valid) return Fault::none;
  if (!is_finite(in.dp_W.sum() + in.dphi_W.sum())) return Fault::input_not_finite;
  return in.dphi_W.squaredNorm() <= pi * pi ? Fault::none : Fault::input_not_unit;
}
inline Fault check(const AdmittanceDevice::Input& in) noexcept {
  return !in.valid || is_finite(sum(in.F_WB)) ? Fault::none : Fault::input_not_finite;
}

inline Fault check(const JointMotionSample& in) noexcept {
  return is_finite(in.q.sum() + in.q_dot.sum()) ? Fault::none : Fault::input_not_finite;
}

template <class S>
bool is_finite(const Params<S>& par, const Scratch<S>& w) noexcept {
  Lanes<S> all = 0;
  for (std::size_t g = 0; g < num_groups(par); ++g) {
    const Next<S>& next = w.next[g];
    all += sum(next.x.X_WB) + next.x.v_W.sum() + next.x.w_B.sum() + sum(next.memory);
  }
  if constexpr (uses<NetOf<S>>)
    for (std::size_t n = 0; n < num_net_nodes(par); ++n) all += sum(w.net.next[n]);
  return is_finite(all);
}

/// Returns the feedback (8) at the end of the step, scaled by the ramp. phi_B: attitude error (16).
template <class S>
Wrench feedback(const BodyParams<S>& par, const CouplingInput& input, const BodyState<S>& body,
                const Vec3& phi_B) noexcept {
  return S::Feedback::wrench(ramped(par.feedback.gains, input.ramp.s), body.x, input.to, phi_B);
}

/// Moves feedback of links without a motor to their parents (9), from the leaves up. The origin of a device
/// link is at its target.
template <class S>
void move_to_driven(const Params<S>& par, Scratch<S>& w) noexcept {
  for (std::size_t i = num_bodies(par); i-- > 0;) {
    const auto& joint = par.bodies[i].joint;
    if (joint.driven) continue;
    if (joint.kind != JointKind::free && joint.parent != world) {
      const Wrench F = moved_to_parent(w.wanted[i], w.coupling_inputs[i].to.X_WD.p,
                                       w.coupling_inputs[joint.parent].to.X_WD.p);
      w.wanted[joint.parent].tau += F.tau;
      w.wanted[joint.parent].f += F.f;
    }
    w.wanted[i] = {};
  }
}

/// Returns the limits that the solver reached in a step that was taken.
template <class S>
Limited limits_of(const Scratch<S>& w) noexcept {
  Limited limited = Limited::none;
  const auto add = [&limited](bool is_met, Limited bit) noexcept { limited |= is_met ? bit : Limited::none; };
  if constexpr (uses<ContactsOf<S>>) {
    add(w.contacts.report.residual_share > doubtful_residual, Limited::contact_residual);
    add(w.contacts.report.num_stopped > 0, Limited::newton_cap);
  }
  if constexpr (iterates_joints<S>) add(w.iteration.subdivides, Limited::substeps);
  if constexpr (uses<NetOf<S>>) add(w.contacts.net.report.is_stopped, Limited::net_cap);
  return limited;
}

template <class S>
void commit(const Params<S>& par, const Scratch<S>& w, State<S>& x) noexcept {
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const Next<S>& next = w.next[i / lanes<S>];
    const std::size_t j = i % lanes<S>;
    x.bodies[i].x = lane(next.x, j);
    if constexpr (!std::is_empty_v<typename S::Integrator::Memory>)
      x.bodies[i].memory = next.memory.of_lane(j);
    if constexpr (uses<typename S::Coupling>) x.bodies[i].coupling.phi_B = lane(next.coupling.phi_B, j);
    if constexpr (uses<typename S::Device>) x.bodies[i].device = state_after(w.coupling_inputs[i]);
    if constexpr (prescribes<S>) x.bodies[i].joint.last = w.prescribed[i].to;
    if constexpr (counts_turns<S>) x.bodies[i].joint.q = w.tree.q[i];
    if constexpr (counts_errors<S>) x.bodies[i].joint.ahead = w.errors.turns[i];
    if constexpr (uses<typename S::Joints>) x.bodies[i].joint.F_C = w.tree.nodes[i].F_C;
    if constexpr (has_stages<S>) x.bodies[i].contact.F_W = w.contacts.wrenches[i];
  }
  if constexpr (uses<NetOf<S>>) {
    std::copy_n(w.net.next.begin(), num_net_nodes(par), x.net.nodes.begin());
    x.net.contacts.assign(w.contacts.net.memories.after());
    if constexpr (has_stages<S>) x.net.forces.assign(w.contacts.net.forces);
  }
  if constexpr (has_stages<S>) x.forces.assign(w.contacts.forces);
  if constexpr (uses<ContactsOf<S>>) x.contacts.assign(w.contacts.memories.after());
  if constexpr (uses<TermsOf<S>>) x.terms = w.term_forces;
  x.tick += 1;
}

/// Advances a scene by one time step of length h.
/// x: state, replaced by that at the end of the step. in: samples of the devices at the end of the step.
/// out: outputs for the devices. A step with a non-finite input or result, or one that fails (58), leaves x
/// unchanged. Only the displayed wrench changes: it falls to zero within its rate limit.
template <Scene S>
// NOLINTNEXTLINE(readability-function-size): one flat list
GODOBJECT_FLATTEN void step(const Params<S>& par, const Input<S>& in, State<S>& x, Scratch<S>& w,
                            Output<S>& out) noexcept GODOBJECT_NONBLOCKING {
  out.fault = Fault::none;
  out.limited = Limited::none;

  // devices: targets (2), ramps (14), applied forces
  if constexpr (uses<typename S::Device>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) out.fault |= check(in.devices[i]);
    if (!any(out.fault))
      for (std::size_t i = 0; i < num_bodies(par); ++i)
        w.coupling_inputs[i] = S::Device::coupling_input(par.bodies[i].device, in.devices[i], x.bodies[i].x,
                                                         par.h, x.bodies[i].device, out.limited);
  }
  if constexpr (prescribes<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) out.fault |= check(in.joints[i]);
    if (!any(out.fault))
      for (std::size_t i = 0; i < num_bodies(par); ++i)
        w.prescribed[i] = prescribe(x.bodies[i].joint, num_axes(par.bodies[i].joint.kind).turns, in.joints[i],
                                    x.bodies[i].device.ramp, w.coupling_inputs[i], par.h);
  }

  // motion, by one or two stages (12), (13) of (10), (11)
  if (!any(out.fault)) {
    if constexpr (iterates_joints<S>) w.iteration.subdivides = false;
    out.limited |= S::Integrator::advance(par, x, w);
    if constexpr (uses<NetOf<S>>) conserve_angular_momentum(par, x, w);
    if (!is_finite(par, w)) out.fault |= Fault::state_not_finite;
    else if (rises_out_of_measure(par, x, w)) out.fault |= Fault::energy_gained;
    if (any(out.fault)) begin_means(par, x, 0, w);
  }
  if (!any(out.fault)) commit(par, w, x);
  const bool taken = !any(out.fault);
  if (taken) out.limited |= limits_of(w);
  if constexpr (uses<ContactsOf<S>>) {
    if (taken) out.contacts = w.contacts.report;
  }
  if constexpr (uses<NetOf<S>>) {
    if (taken) out.net = w.contacts.net.report;
  }
  if constexpr (uses<TermsOf<S>>) {
    if (taken) out.terms = w.means.terms;
  }

  // feedback: (8), moved to driven links (9), bounded
  if constexpr (uses<typename S::Feedback>) {
    const auto errors = coupling_errors<S>(
        par, x, [&x](std::size_t i) -> const Quat& { return x.bodies[i].x.X_WB.q; },
        [&w](std::size_t i) -> const Quat& { return w.coupling_inputs[i].to.X_WD.q; });
    const auto wanted = [&](std::size_t i) noexcept {
      const bool live = !any(out.fault) && w.coupling_inputs[i].live;
      return live ? feedback(par.bodies[i], w.coupling_inputs[i], x.bodies[i], errors[i].phi_B) : Wrench{};
    };
    const auto show = [&](std::size_t i, const Wrench& F) noexcept {
      constexpr Gap none{};
      const Gap& gap = any(out.fault) ? none : w.coupling_inputs[i].gap;
      S::Feedback::show(par.bodies[i].feedback, gap, F, par.h, x.bodies[i].feedback, out.bodies[i].feedback,
                        out.limited);
    };
    if constexpr (uses<typename S::Joints>) {
      for (std::size_t i = 0; i < num_bodies(par); ++i) w.wanted[i] = wanted(i);
      move_to_driven(par, w);
      for (std::size_t i = 0; i < num_bodies(par); ++i) show(i, w.wanted[i]);
    } else {
      for (std::size_t i = 0; i < num_bodies(par); ++i) show(i, wanted(i));
    }
  }

  // output
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const BodyState<S>& body = x.bodies[i];
    // after a fault the previous state remains; the last pose too, if the caller damaged the state
    if (any(out.fault) && !is_finite(sum(body.x.X_WB) + body.x.v_W.sum() + body.x.w_B.sum())) continue;
    if constexpr (uses<typename S::Joints>) {
      if (!any(out.fault)) out.bodies[i].joint = w.means.bodies[i].joint;
    }
    if constexpr (uses<ContactsOf<S>>) {
      if (!any(out.fault)) out.bodies[i].contact = w.means.bodies[i].contact;
    }
    out.bodies[i].X_WB = body.x.X_WB;
    out.bodies[i].V_WB = {.w = to_world(body.x.X_WB.q, body.x.w_B), .v = body.x.v_W};
  }
  if constexpr (uses<ContactsOf<S>>) {
    if (taken && w.contacts.near.full()) out.fault |= Fault::contacts_full;
    if (taken && w.contacts.report.num_without_room > 0) out.fault |= Fault::blocks_full;
  }
  if constexpr (uses<NetOf<S>>) {
    if (taken && w.contacts.net.near.full()) out.fault |= Fault::contacts_full;
  }
}

}  // namespace godobject
