// Energy balance of a scene: total energy E, work W done by devices and prescribed joints, and a check that E
// - W does not increase. Callers run it after each step; the step itself does not need it. An increase
// without external work means that the simulation is no longer valid.
//
//   (38)  E - W falls:  E = motion, gravity, springs (coupling, contacts, stops, terms);  W = external work
//
// Dampers, friction and the integrators only dissipate. W is bounded from above. The work of a coupling is
// that of its target moving before the body, or of the mean of its forces: the greater one.
#pragma once

#include <utility>

#include "core/gain_watch.h"
#include "core/net_energy.h"
#include "core/stage.h"

namespace godobject {

/// Returns the energy in the spring of a stop (19), J.
inline Real stop_energy(const StopParams& par, Real q) noexcept {
  const Real d = std::max(par.lower - q, Real(0)) + std::max(q - par.upper, Real(0));
  const Real s = std::min(d, par.width);
  if (!(s > 0)) return 0;
  return par.k * (s * s * s / (6 * par.width) + (d - s) * d / 2);
}

/// Accumulates the energy balance of a scene outside the step.
template <Scene S>
class EnergyBalance {
 public:
  /// Starts the balance with the state before the first step.
  void start(const Params<S>& par, const State<S>& x) noexcept {
    *this = {};
    const auto errors = errors_of(par, x);
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      last_[i] = coupled(par, x, i, errors);
      energy_ += last_[i].energy;
    }
    gravity_ = gravity_energy(par, x);
    energy_ += kinetic(par, x) + gravity_ + (other_springs(par, x) + net_springs(par, x));
    watch_.start(energy_);
  }

  /// Updates the balance after a step that was taken, from its state, scratch and output.
  void observe(const Params<S>& par, const State<S>& x, const Scratch<S>& w, const Output<S>& out) noexcept {
    const Real T = kinetic(par, x), gravity = gravity_energy(par, x), of_nets = net_springs(par, x);
    Real U = gravity + (other_springs(par, x) + of_nets), W = 0,
         floor = gain_floor + net_gain_floor * of_nets;
    const auto errors = errors_of(par, x), moved = errors_of(par, x, last_.data());
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const RigidBodyState& body = x.bodies[i].x;
      const Coupled now = coupled(par, x, i, errors);
      if (now.pulls || last_[i].pulls) W += coupling_work(par, x, w, i, now, moved);
      U += now.energy;
      last_[i] = now;
      if constexpr (uses<typename S::Device>) {
        const Wrench& F_WB = w.coupling_inputs[i].F_WB;
        const Real power = F_WB.f.dot(body.v_W) + F_WB.tau.dot(to_world(body.X_WB.q, body.w_B)),
                   before = std::exchange(hand_[i], power);
        // implicit Euler moves by the force at the end, TR-BDF2 by those of the whole step
        W += par.h * (S::Integrator::order == 1 ? power : std::max(power, Real(0.5) * (power + before)));
      }
      if constexpr (prescribes<S>) W += joint_work(par, x, i);
    }
    Real may_give = 0;  // bound of work that is unknown in this step, J
    if constexpr (uses<ContactsOf<S>>) {
      const Springs springs = contact_springs(par, x, w);
      U += springs.energy;
      floor += springs.floor;
      W += out.contacts.found;
      if (!is_of_euler_stages(out)) may_give = springs.may_find;
    }
    if constexpr (prescribes<S>) {
      if (is_ramping_to_prescribed(par, out)) may_give = std::numeric_limits<Real>::infinity();
    }
    W += std::clamp(T + U - W - energy_, Real(0), may_give);
    const Real by_gravity = gravity - gravity_;
    gravity_ = gravity;
    energy_ = T + U;
    if (std::isfinite(W)) work_ += W;  // keeps the reference finite after a step out of all bounds
    watch_.observe(energy_ - work_, T, std::abs(W) + std::abs(by_gravity),
                   floor + rounding_share * std::abs(energy_), par.h);
  }

  Real energy() const noexcept { return energy_; }           // E, J
  Real balance() const noexcept { return energy_ - work_; }  // E - W, J
  const GainWatch& watch() const noexcept { return watch_; }
  /// Returns the coupling of body i at the end of the last step; without gains if nothing pulls the body.
  const CouplingAt& coupling(std::size_t i) const noexcept { return last_[i]; }
  /// True if the energy has increased without external work, beyond the tolerance.
  bool gains() const noexcept { return watch_.gains(); }

  /// Returns the energy of all springs except those of couplings and contacts, J.
  static Real springs(const Params<S>& par, const State<S>& x) noexcept {
    return other_springs(par, x) + net_springs(par, x);
  }

  static Real kinetic(const Params<S>& par, const State<S>& x) noexcept {
    return kinetic_energy_of(par, MotionsOfState<S>{x});
  }

 private:
  /// A body and its coupling at the end of a step.
  struct Coupled : CouplingAt {
    bool pulls = false;  // true if it has a coupling
    Pose X_WB;
    Target target;
    Real s = 0;  // ramp of the coupling at the end of the step, 0 to 1
  };

  /// Returns the errors of all couplings, at the poses of the state or of `last`. Empty without couplings.
  static auto errors_of([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                        [[maybe_unused]] const Coupled* last = nullptr) noexcept {
    if constexpr (uses<typename S::Coupling>) {
      const auto pose = [&x, last](std::size_t i) -> const Quat& {
        return last != nullptr ? last[i].X_WB.q : x.bodies[i].x.X_WB.q;
      };
      const auto target = [&x](std::size_t i) -> const Quat& { return x.bodies[i].device.last.X_WD.q; };
      return coupling_errors(par, x, pose, target);
    } else {
      return Empty{};
    }
  }

  static Coupled coupled([[maybe_unused]] const Params<S>& par, const State<S>& x, std::size_t i,
                         [[maybe_unused]] const auto& errors) noexcept {
    if constexpr (uses<typename S::Coupling>) {
      const BodyState<S>& body = x.bodies[i];
      if (godobject::pulls(par.bodies[i].coupling))
        return {coupling_at(par, x, i, errors), true, body.x.X_WB, body.device.last, body.device.ramp.s};
    }
    return {};
  }

  /// Returns the energy in the springs of nets, J.
  static Real net_springs([[maybe_unused]] const Params<S>& par,
                          [[maybe_unused]] const State<S>& x) noexcept {
    if constexpr (uses<NetOf<S>>) return net_spring_energy(par, x);
    return 0;
  }

  /// Returns the energy of stops and terms, J.
  static Real other_springs(const Params<S>& par, const State<S>& x) noexcept {
    Real U = 0;
    if constexpr (uses<typename S::Joints>) {
      for (std::size_t i = 0; i < num_bodies(par); ++i) U += stops_energy(par, x, i);
    }
    if constexpr (uses<TermsOf<S>>) U += term_energy(par, x);
    return U;
  }

  static Real gravity_energy(const Params<S>& par, const State<S>& x) noexcept {
    Vec3 mp_W = Vec3::Zero();
    for (std::size_t i = 0; i < num_bodies(par); ++i) mp_W += par.bodies[i].body.m * x.bodies[i].x.X_WB.p;
    if constexpr (uses<NetOf<S>>) mp_W += net_mass_moment(par, x);
    return -par.gravity_W.dot(mp_W);
  }

  /// Returns the work of the coupling's target and of the ramp, J. moved: errors of the targets after their
  /// motion, of the bodies before.
  Real coupling_work(const Params<S>& par, const State<S>& x, const Scratch<S>& w, std::size_t i,
                     const Coupled& now, [[maybe_unused]] const auto& moved) const noexcept {
    if constexpr (uses<typename S::Coupling>) {
      const BodyState<S>& body = x.bodies[i];
      const Target& D = now.target;
      const Coupled& last = last_[i];
      const SpringParams& spring = now.spring;
      const Vec3 v_W = body.x.v_W, w_W = to_world(body.x.X_WB.q, body.x.w_B);
      // The target is moved before the body. The damper acts at the sample's velocity or at the mean velocity
      // of the target's way, and the larger work counts.
      const Vec3 e_W = D.X_WD.p - last.X_WB.p;
      const Vec3 shift = D.X_WD.p - last.target.X_WD.p;
      const Vec3 turned =
          to_world(last.target.X_WD.q, rotation_error(last.target.X_WD.q, D.X_WD.q, Vec3::Zero()).phi_B);
      const auto damped = [&](const Vec3& v_D, const Vec3& w_D) noexcept {
        return par.h * (spring.g * (v_D - v_W).dot(v_D) + spring.g_r * (w_D - w_W).dot(w_D));
      };
      Real W = Real(0.5) * (spring.k * e_W.squaredNorm() + spring.k_r * moved[i].twice_energy) - last.energy;
      W += std::max(damped(D.V_WD.v, D.V_WD.w), damped(shift * (1 / par.h), turned * (1 / par.h)));
      if (w.coupling_inputs[i].fresh || !(now.s > 0)) return W;
      // or both together, by the mean of the forces
      const Wrench &F = now.F_WB, &F_0 = last.F_WB;
      const Real share = last.s / now.s;
      return std::max(W, Real(0.5) * ((F.f + F_0.f).dot(shift) + (F.tau + F_0.tau).dot(turned)) +
                             now.energy * (1 - share * share));
    }
    return 0;
  }

  static Real stops_energy(const Params<S>& par, const State<S>& x, std::size_t i) noexcept {
    Real E = 0;
    if constexpr (uses<typename S::Joints::Stops>) {
      const auto& joint = par.bodies[i].joint;
      const auto is_none = [](const StopParams& stop) noexcept { return !(stop.k > 0); };
      if (is_none(joint.stop.stops[0]) && is_none(joint.stop.stops[1])) return 0;
      with_joint(joint.kind, [&](auto kind) noexcept {
        if constexpr (requires { kind.coordinates(JointFrames{}); }) {
          const JointAt at = joint_at(joint, place_of(par, x, joint.parent), place_of(par, x, i));
          const JointCoordinates q = counted<decltype(kind)>(at.X, at.V.w, x.bodies[i].joint.q, 0);
          for (std::size_t c = 0; c < 2; ++c)
            E += stop_energy(joint.stop.stops[c], q[static_cast<Eigen::Index>(c)]);
        }
      });
    }
    return E;
  }

  /// True while TR-BDF2 ramps prescribed coordinates towards the device's. The work is unknown then, because
  /// the forces at the end of a step oscillate.
  static bool is_ramping_to_prescribed(const Params<S>& par, const Output<S>& out) noexcept {
    if (S::Integrator::order == 1 || !has(out.limited, Limited::ramp)) return false;
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      if (par.bodies[i].joint.motion.prescribed) return true;
    return false;
  }

  /// Returns the work of a prescribed joint, J: from the power at the end of the step (implicit Euler) or its
  /// mean over the step.
  Real joint_work(const Params<S>& par, const State<S>& x, std::size_t i) noexcept {
    const auto& joint = par.bodies[i].joint;
    if (joint.kind == JointKind::free || !joint.motion.prescribed) return 0;
    const TreePlace P = place_of(par, x, joint.parent), C = place_of(par, x, i);
    const Wrench& F = x.bodies[i].joint.F_C;  // wrench of the last stage
    const Vec3 v = C.V.v - P.V.v - P.V.w.cross(C.a_W - P.a_W);
    const Real power = F.f.dot(v) + F.tau.dot(C.V.w - P.V.w),
               before = std::exchange(prescribed_power_[i], power);
    return par.h * std::max(power, Real(0.5) * (power + before));
  }

  static Real term_energy(const Params<S>& par, const State<S>& x) noexcept {
    Real E = 0;
    TermsOf<S>::each_param(
        par.terms, [&](auto kind, const auto& one) noexcept { E += kind.energy(one, TermPlaces<S>{x}); });
    return E;
  }

  /// Energy stored in contact springs, J.
  struct Springs {
    Real energy = 0;
    Real may_find = 0;  // (35)  bound of energy that deeper contacts may add in a stage, J
    Real floor = 0;     // part of it that may be stored without any motion pressing the springs
  };

  /// True if the report covers every stage of the step. A second-order step begins its stages elsewhere; its
  /// initial contact energy is bounded by (35) and counts as external where E increases.
  static constexpr bool is_of_euler_stages(const Output<S>& out) noexcept {
    return S::Integrator::order == 1 || has(out.limited, Limited::first_order);
  }

  static Springs contact_springs(const Params<S>& par, const State<S>& x, const Scratch<S>& w) noexcept {
    Springs sum;
    const auto mass = [&](std::uint32_t i) noexcept -> Real {
      return i < num_bodies(par) ? par.bodies[i].body.m : std::numeric_limits<Real>::infinity();
    };
    const auto add = [&](const auto& memories, const auto& near, auto law_of, auto mass_of) noexcept {
      Recall recall(memories);
      for (std::size_t k = 0; k < near.size; ++k) {
        const ContactMemory* const contact = recall.find(near.list[k].key);
        if (contact == nullptr) continue;
        const ContactLaw& law = law_of(near.list[k]);
        const Real m = std::min(mass_of(near.list[k].a), mass(near.list[k].b)), pressed = contact->pressed;
        sum.energy += stored_energy(law, pressed, dot(contact->xi_a, contact->xi_a));
        sum.may_find += max_found_energy(law, pressed, m);
        sum.floor += push_out_energy(law, m);
      }
    };
    add(
        x.contacts, w.contacts.near,
        [&](const NearContact& near) -> const ContactLaw& { return law_of(par.contacts, near); }, mass);
    if constexpr (uses<NetOf<S>>) {
      add(
          x.net.contacts, w.contacts.net.near,
          [&](const NearContact& near) -> const ContactLaw& {
            return law_of<ContactsOf<S>, NetOf<S>>(par.contacts, par.net, near);
          },
          [&](std::uint32_t n) { return par.net.nodes[n].m; });
    }
    return sum;
  }

  std::array<Coupled, S::max_bodies> last_;
  std::array<Real, S::max_bodies> hand_{};  // power of applied forces, W
  [[no_unique_address]] std::conditional_t<prescribes<S>, std::array<Real, S::max_bodies>, Absent<23>>
      prescribed_power_{};  // W
  Real energy_ = 0, work_ = 0, gravity_ = 0;
  GainWatch watch_;
};

}  // namespace godobject
