// The balance of energy of a scene: what it has, what the device and led joints have done on it, and whether it has gained
// more than that. The step does not need it; who runs one asks it after each step, since a scene that gains energy has
// left what it simulates.
//
//   (38)  E - W falls:  E = motion, gravity, springs (coupling, contacts, stops, terms);  W = work done from outside
//
// Dampers, friction and the integrators only take. W is bounded from above: of what a coupling does, by its target that
// moves before the body does, or by the mean of its forces, whichever is more.
#pragma once

#include "core/energy.h"
#include "core/step.h"

namespace godobject {

/// What share of the energy at work a scene may gain within the window, in which numbers are of second order only.
inline constexpr Real gain_allowed = 0.01;
/// s, at most: gains that are older are forgotten. At least half of it is remembered.
inline constexpr Real gain_window = 1;

/// Says when E - W rises. Energy at work: the largest kinetic energy in the window, and the work done in it.
class GainWatch {
 public:
  /// After each step; floor: J that are no gain. Returns the gain, J, in `of` what it is a gain of.
  Real observe(Real E_less_W, Real T, Real work, Real floor, Real h) noexcept {
    age_ += h;
    if (age_ >= gain_window / 2) {
      before_ = now_;
      now_ = {.least = E_less_W};
      age_ = 0;
    }
    now_.least = std::min(now_.least, E_less_W);
    now_.kinetic = std::max(now_.kinetic, T);
    now_.work += std::abs(work);
    gained_ = E_less_W - std::min(now_.least, before_.least);
    of_ = std::max(now_.kinetic, before_.kinetic) + now_.work + before_.work;
    gains_ = gained_ > gain_allowed * of_ + floor;
    return gained_;
  }
  void start_anew() noexcept { *this = {}; }
  bool gains() const noexcept { return gains_; }
  Real gained() const noexcept { return gained_; }  // J within the window
  Real at_work() const noexcept { return of_; }     // J likewise

 private:
  struct Span {
    Real least = std::numeric_limits<Real>::infinity(), kinetic = 0, work = 0;
  };
  Span now_, before_;
  Real age_ = 0, gained_ = 0, of_ = 0;
  bool gains_ = false;
};

/// Of a stop (19): the energy in its spring.
inline Real stop_energy(const StopParams& par, Real q) noexcept {
  const Real d = std::max(par.lower - q, Real(0)) + std::max(q - par.upper, Real(0));
  const Real s = std::min(d, par.width);
  if (!(s > 0)) return 0;
  return par.k * (s * s * s / (6 * par.width) + (d - s) * d / 2);
}

/// Of a scene. Not a part of it: the step knows nothing of it.
template <Scene S>
class EnergyBalance {
 public:
  /// After each step, of the states, scratch and output of that step.
  void observe(const Params<S>& par, const State<S>& x, const Scratch<S>& w, const Output<S>& out) noexcept {
    Real T = 0, U = 0, W = 0, floor = 0;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const RigidBodyParams& body = par.bodies[i].body;
      T += kinetic_energy(body, x.bodies[i].x);
      U -= body.m * par.gravity_W.dot(x.bodies[i].x.X_WB.p);
      if constexpr (uses<typename S::Coupling>) W += coupling_work(par, x, w, i, U);
      if constexpr (uses<typename S::Device>)
        W += par.h * (w.pulls[i].F_WB.f.dot(x.bodies[i].x.v_W) +
                      w.pulls[i].F_WB.tau.dot(to_world(x.bodies[i].x.X_WB.q, x.bodies[i].x.w_B)));
      if constexpr (uses<typename S::Joints>) W += joint_work(par, x, out, i, U);
      last_[i].X_WB = x.bodies[i].x.X_WB;
    }
    if constexpr (uses<NodesOf<S>>) {
      for (std::size_t j = 0; j < num_nodes(par); ++j) {
        const Real m = par.nodes.list[j].m;
        T += Real(0.5) * m * x.nodes[j].v_W.squaredNorm();
        U -= m * par.gravity_W.dot(x.nodes[j].p_W);
      }
    }
    if constexpr (uses<TermsOf<S>>) U += term_energy(par, x);
    if constexpr (uses<ContactsOf<S>>) W += contact_work(par, x, w, U, floor);
    energy_ = T + U;
    if (!started_) W = 0;
    started_ = true;
    work_ += W;
    floor += Real(1e-12) * std::abs(energy_);
    watch_.observe(energy_ - work_, T, W, floor, par.h);
  }

  Real energy() const noexcept { return energy_; }           // E, J
  Real balance() const noexcept { return energy_ - work_; }  // E - W, J
  const GainWatch& watch() const noexcept { return watch_; }

 private:
  struct Last {
    Pose X_WB;
    Target target;
    Wrench F_WB;
    Real energy = 0, s = 0;
  };

  /// Of the coupling's target; its energy is added to U.
  Real coupling_work(const Params<S>& par, const State<S>& x, const Scratch<S>& w, std::size_t i,
                     Real& U) noexcept {
    const BodyState<S>& body = x.bodies[i];
    const Target& D = body.device.last;
    const Real s = body.device.ramp.s, E = coupling_energy(par, x, i);
    const SpringParams spring = ramped(par.bodies[i].coupling, s);
    const Wrench F = coupling_wrench(par, x, i);
    Last& last = last_[i];
    const Vec3 phi_B = rotation_error(last.X_WB.q, D.X_WD.q, body.coupling.phi_B).phi_B;
    const Vec3 e_W = D.X_WD.p - last.X_WB.p, w_W = to_world(body.x.X_WB.q, body.x.w_B);
    Real W = Real(0.5) * (spring.k * e_W.squaredNorm() + spring.k_r * phi_B.squaredNorm()) - last.energy;
    W += par.h *
         (spring.g * (D.V_WD.v - body.x.v_W).dot(D.V_WD.v) + spring.g_r * (D.V_WD.w - w_W).dot(D.V_WD.w));
    if (!w.pulls[i].fresh && s == last.s) {
      const Vec3 turn_B = rotation_error(last.target.X_WD.q, D.X_WD.q, Vec3::Zero()).phi_B;
      W = std::max(W, Real(0.5) * ((F.f + last.F_WB.f).dot(D.X_WD.p - last.target.X_WD.p) +
                                   (F.tau + last.F_WB.tau).dot(to_world(last.target.X_WD.q, turn_B))));
    }
    U += E;
    last.target = D;
    last.F_WB = F;
    last.energy = E;
    last.s = s;
    return W;
  }

  /// Of a joint that the device leads; the energy in the stops of others is added to U.
  Real joint_work(const Params<S>& par, const State<S>& x, const Output<S>& out, std::size_t i,
                  Real& U) noexcept {
    const auto& joint = par.bodies[i].joint;
    const auto place_of = [&](std::size_t b) noexcept {
      return b == world ? TreePlace{} : place<Real>(par.bodies[b].joint.C.p, x.bodies[b].x);
    };
    if (joint.kind == JointKind::free) return 0;
    const TreePlace P = place_of(joint.parent), C = place_of(i);
    if constexpr (uses<typename S::Joints::Stops>) {
      with_joint(joint.kind, [&](auto kind) noexcept {
        if constexpr (requires { kind.coordinates(JointFrames{}); }) {
          const JointCoordinates q = kind.coordinates(joint_at(joint, P, C).X);
          for (Eigen::Index c = 0; c < 2; ++c)
            U += stop_energy(joint.stop.stops[static_cast<std::size_t>(c)], q[c]);
        }
      });
    }
    if constexpr (imposes<S>) {
      if (!joint.lead.imposed) return 0;
      const Wrench& F = out.bodies[i].joint.F_C;
      const Vec3 v = C.V.v - P.V.v - P.V.w.cross(C.a_W - P.a_W);
      return par.h * (F.f.dot(v) + F.tau.dot(C.V.w - P.V.w));
    }
    return 0;
  }

  static Real term_energy(const Params<S>& par, const State<S>& x) noexcept {
    const auto point = [&](std::uint32_t u, const Vec3& p) noexcept -> Vec3 {
      if (u == TermEnds::on_world) return p;
      if constexpr (uses<NodesOf<S>>)
        if (u >= S::max_bodies) return x.nodes[u - S::max_bodies].p_W;
      const Pose& X = x.bodies[u].x.X_WB;
      return X.p + to_world(X.q, p);
    };
    Real E = 0;
    TermsOf<S>::each_param(par.terms,
                           [&](auto kind, const auto& one) noexcept { E += kind.energy(one, point); });
    return E;
  }

  /// Of rest penetrations (35) that are relaxed and that are found; the energy in the contacts is added to U.
  Real contact_work(const Params<S>& par, const State<S>& x, const Scratch<S>& w, Real& U,
                    Real& floor) const noexcept {
    Real W = 0;
    Recall recall(x.contacts);
    for (std::size_t k = 0; k < w.contacts.near.size; ++k) {
      const NearContact& near = w.contacts.near.list[k];
      const ContactMemory* const contact = recall.find(near.key);
      if (contact == nullptr) continue;
      const ContactLaw& law = law_of(par.contacts, near);
      U += Real(0.5) * (law.k * contact->pressed * contact->pressed + law.k_t * contact->xi_W.squaredNorm());
      if (contact->e > 0) W += par.h * law.push_out * contact->n_W.dot(contact->F_W);
      if (near.a < S::max_bodies)
        floor += Real(0.5) * par.bodies[near.a].body.m * law.push_out * law.push_out;
    }
    return W;
  }

  std::array<Last, S::max_bodies> last_{};
  Real energy_ = 0, work_ = 0;
  bool started_ = false;
  GainWatch watch_;
};

}  // namespace godobject
