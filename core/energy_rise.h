// Rejection of steps with an excessive rise of energy. Such a step is a failed solve of any cause, and is not
// taken.
//
//   (58)  T+ <= c (T + U + W)
//
// T, T+: kinetic energy before and after the step. U: energy of all springs. W: bound of the work of gravity,
// targets, forces and prescribed joints in the step, done from rest: from T, it adds up to 2 (T + W) at most.
// c is far above that: smaller gains are left to the energy balance (38).
#pragma once

#include "core/energy_balance.h"

namespace godobject {

/// Mass and inertia of the whole scene, for the energy of a prescribed motion that moves all of it.
class Whole {
 public:
  template <Scene S>
  Whole(const Params<S>& par, const State<S>& x) noexcept {
    const auto each = [&](auto f) noexcept {
      for (std::size_t i = 0; i < num_bodies(par); ++i) f(par.bodies[i].body.m, x.bodies[i].x.X_WB.p);
      if constexpr (uses<NetOf<S>>)
        for (std::size_t n = 0; n < num_net_nodes(par); ++n) f(par.net.nodes[n].m, x.net.nodes[n].p_W);
    };
    Vec3 mp_W = Vec3::Zero();
    each([&](Real m, const Vec3& p_W) noexcept {
      m_ += m;
      mp_W += m * p_W;
    });
    c_W_ = mp_W / m_;
    each([&](Real m, const Vec3& p_W) noexcept { I_ += m * (p_W - c_W_).squaredNorm(); });
    for (std::size_t i = 0; i < num_bodies(par); ++i) I_ += par.bodies[i].body.I_B.trace();
  }
  /// Returns a bound of the kinetic energy at the speed v of the point p_W and the angular speed w, J.
  Real energy(const Vec3& p_W, Real v, Real w) const noexcept {
    return m_ * v * v + (I_ + m_ * (p_W - c_W_).squaredNorm()) * w * w;
  }
  Real mass() const noexcept { return m_; }

 private:
  Real m_ = 0, I_ = 0;  // I_: trace of the inertia about the centre
  Vec3 c_W_;
};

/// Motions at the end of the step.
template <class S>
struct NextMotions {
  const Scratch<S>& w;

  RigidBodyState body(std::size_t i) const noexcept { return lane(w.next[i / lanes<S>].x, i % lanes<S>); }
  const Vec3& net_node(std::size_t n) const noexcept { return w.net.next[n].v_W; }
};

/// Returns a bound of the counted turns in the error of body i (16), rad.
template <Scene S>
Real max_counted([[maybe_unused]] const State<S>& x, [[maybe_unused]] std::size_t i) noexcept {
  Real turns = 0;
  if constexpr (counts_errors<S>) {
    for (const TurnsAhead::About& about : x.bodies[i].joint.ahead.list)
      turns += std::abs(static_cast<Real>(about.turns));
  }
  return 2 * pi * turns;
}

/// Returns a lower bound of the moment of inertia about any axis, kg m^2.
inline Real least_inertia(const RigidBodyParams& body) noexcept {
  return body.I_B.trace() / (3 * body.anisotropy * body.anisotropy);
}

/// Returns W of the coupling and the applied wrench of body i (58), J.
template <Scene S>
Real work_of_device([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                    [[maybe_unused]] const Scratch<S>& w, [[maybe_unused]] const Whole& whole,
                    [[maybe_unused]] std::size_t i) noexcept {
  Real W = 0;
  if constexpr (uses<typename S::Coupling>) {
    const SpringParams& spring = par.bodies[i].coupling;
    const Pose& X_WB = x.bodies[i].x.X_WB;
    const Target &from = w.coupling_inputs[i].from, &to = w.coupling_inputs[i].to;
    if (pulls(spring)) {
      // the cubic (15) of TR-BDF2 overshoots both ends, in proportion to their velocities
      const auto angle = [](const Quat& a, const Quat& b) noexcept {
        return rotation_error(a, b, Vec3::Zero()).phi_B.norm();
      };
      const Real moved = (to.X_WD.p - from.X_WD.p).norm(), turned = angle(from.X_WD.q, to.X_WD.q),
                 v = to.V_WD.v.norm() + from.V_WD.v.norm(), w_D = to.V_WD.w.norm() + from.V_WD.w.norm(),
                 e = (to.X_WD.p - X_WB.p).norm() + moved + par.h * v,
                 alpha = angle(X_WB.q, to.X_WD.q) + max_counted(x, i) + turned + par.h * w_D;
      W += Real(0.5) * (spring.k * e * e + spring.k_r * alpha * alpha) +
           whole.energy(X_WB.p, v + moved / par.h, w_D + turned / par.h);
    }
  }
  if constexpr (uses<typename S::Device>) {
    const RigidBodyParams& body = par.bodies[i].body;
    const Wrench F = w.coupling_inputs[i].F_WB;
    W += Real(0.5) * par.h * par.h * (F.f.squaredNorm() / body.m + F.tau.squaredNorm() / least_inertia(body));
  }
  return W;
}

/// Returns W of the acceleration from which a second-order step starts (12), (58), J. Its force is not at
/// hand any more: an applied force may have fallen since.
template <Scene S>
Real work_of_memory([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                    [[maybe_unused]] std::size_t i) noexcept {
  if constexpr (std::is_empty_v<typename S::Integrator::Memory>) return 0;
  else {
    const RigidBodyParams& body = par.bodies[i].body;
    const auto& memory = x.bodies[i].memory;
    if (!memory.known) return 0;
    return Real(0.5) * par.h * par.h *
           (body.m * memory.a_W.squaredNorm() + memory.alpha_B.dot(body.I_B * memory.alpha_B));
  }
}

/// Returns W of constant forces (58), J, without their potential, which may be of any sign.
template <Scene S>
Real work_of_constant_forces([[maybe_unused]] const Params<S>& par,
                             [[maybe_unused]] const State<S>& x) noexcept {
  Real W = 0;
  if constexpr (uses<TermsOf<S>>) {
    TermsOf<S>::each_param(par.terms, [&]([[maybe_unused]] auto kind, const auto& force) noexcept {
      if constexpr (requires { force.F_W; }) {
        Real per_mass = 0;
        if (force.at.on < num_bodies(par)) {
          const RigidBodyParams& body = par.bodies[force.at.on].body;
          per_mass = 1 / body.m + force.at.p.squaredNorm() / least_inertia(body);
        }
        W += Real(0.5) * par.h * par.h * per_mass * force.F_W.squaredNorm() -
             kind.energy(force, TermPlaces<S>{x});
      }
    });
  }
  return W;
}

/// Returns W of a prescribed joint of body i, and of the correction of a violated one (58), J.
template <Scene S>
Real work_of_joint([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                   [[maybe_unused]] const Scratch<S>& w, [[maybe_unused]] const Whole& whole,
                   [[maybe_unused]] std::size_t i) noexcept {
  Real W = 0;
  if constexpr (uses<typename S::Joints>) {
    const auto& joint = par.bodies[i].joint;
    if (joint.kind == JointKind::free) return 0;
    const Vec3& p_W = x.bodies[i].x.X_WB.p;
    const Real turned = max_turned_back / par.h, moved = max_moved_back / par.h * joint.C.p.norm();
    W += whole.energy(p_W, moved, turned);
    if constexpr (prescribes<S>) {
      const PrescribedMotion& lead = w.prescribed[i];
      const Real rate =
          (lead.to.q - lead.from.q).norm() / par.h + lead.from.q_dot.norm() + lead.to.q_dot.norm();
      if (joint.motion.prescribed) W += whole.energy(p_W, rate, rate);
    }
  }
  return W;
}

/// Returns U of contacts (58), J: a bound, because contacts that opened in the step have no law any more. The
/// stiffest law is used for all. A contact with unexplained penetration (35) may hold energy of push-out.
template <Scene S>
Real energy_of_contacts([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                        [[maybe_unused]] const Whole& whole) noexcept {
  Real U = 0;
  if constexpr (uses<ContactsOf<S>>) {
    ContactLaw all = par.contacts.laws[0][0];
    for (const auto& row : par.contacts.laws)
      for (const ContactLaw& law : row) all = stiffest(all, law);
    const auto add = [&](const auto& memories) noexcept {
      for (std::size_t i = 0; i < memories.size; ++i) {
        const ContactMemory& contact = memories.list[i];
        U += 2 * stored_energy(all, contact.pressed, 0) +
             stored_energy(all, 0, dot(contact.xi_a, contact.xi_a));
      }
    };
    add(x.contacts);
    if constexpr (uses<NetOf<S>>) add(x.net.contacts);
    U += 2 * push_out_energy(all, whole.mass());
  }
  return U;
}

/// True if the step of w.next violates (58).
template <Scene S>
[[gnu::noinline]] bool rises_out_of_measure(const Params<S>& par, const State<S>& x, const Scratch<S>& w,
                                            Real T, Real T_after) noexcept {
  const Whole whole(par, x);
  const Real v_g = par.h * par.gravity_W.norm();
  Real at_hand = T + EnergyBalance<S>::springs(par, x) + work_of_constant_forces(par, x) +
                 energy_of_contacts(par, x, whole) + whole.mass() * v_g * v_g;
  for (std::size_t i = 0; i < num_bodies(par); ++i)
    at_hand +=
        work_of_device(par, x, w, whole, i) + work_of_memory(par, x, i) + work_of_joint(par, x, w, whole, i);
  return T_after > max_rise * (at_hand + gain_floor);
}

/// True if the step must be rejected by (58). If motion has grown little, springs and work are not evaluated.
template <Scene S>
bool rises_out_of_measure(const Params<S>& par, const State<S>& x, const Scratch<S>& w) noexcept {
  const Real T = EnergyBalance<S>::kinetic(par, x), T_after = kinetic_energy_of(par, NextMotions<S>{w});
  if (T_after <= max_rise * (T + gain_floor)) return false;
  return rises_out_of_measure(par, x, w, T, T_after);
}

}  // namespace godobject
