// Means over a step of contact and joint forces. Velocities change by the forces of all stages, each with its
// share of the step. The mean times h is therefore the change of momentum.
//
//   (13)  v_n+1 - v_n = h (b K_0 + b K_1 + d K_2),  so  F = b F_0 + b F_1 + d F_2;
//         F_0 of the last stage of the step before
#pragma once

#include "core/stage.h"

namespace godobject {

/// True if contacts or joints carry forces in the scene.
template <class S>
inline constexpr bool has_means = uses<ContactsOf<S>> || uses<typename S::Joints>;

/// Adds share times F to a mean.
inline void add_share(const Wrench& F, Real share, Wrench& mean) noexcept {
  mean.tau += share * F.tau;
  mean.f += share * F.f;
}

/// Adds the contact and joint forces of the solved stage, which is this share of the step.
template <Scene S>
void add_to_means([[maybe_unused]] const Params<S>& par, [[maybe_unused]] Real share,
                  [[maybe_unused]] Scratch<S>& w) noexcept {
  if constexpr (has_means<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      auto& mean = w.means.bodies[i];
      if constexpr (uses<ContactsOf<S>>) add_share(w.contacts.wrenches[i], share, mean.contact.F_W);
      if constexpr (uses<typename S::Joints>) add_share(w.tree.nodes[i].F_C, share, mean.joint.F_C);
    }
    if constexpr (uses<ContactsOf<S>>) w.means.contacts.add(w.contacts.forces, share);
    if constexpr (uses<NetOf<S>>) w.means.of_nodes.add(w.contacts.net.forces, share);
    if constexpr (uses<TermsOf<S>>)
      for (std::size_t t = 0; t < par.terms.size(); ++t)
        add_share(w.term_forces.list[t], share, w.means.terms.list[t]);
  }
}

/// Begins the means of a step with the given share of the forces of the previous step's last stage.
template <Scene S>
void begin_means([[maybe_unused]] const Params<S>& par, [[maybe_unused]] const State<S>& x,
                 [[maybe_unused]] Real share, [[maybe_unused]] Scratch<S>& w) noexcept {
  if constexpr (has_means<S>) {
    w.means.bodies.fill({});
    if constexpr (uses<ContactsOf<S>>) w.means.contacts.size = 0;
    if constexpr (uses<NetOf<S>>) w.means.of_nodes.size = 0;
    if constexpr (uses<TermsOf<S>>) w.means.terms = {};
    if (!(share > 0)) return;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      auto& mean = w.means.bodies[i];
      if constexpr (has_stages<S>) add_share(x.bodies[i].contact.F_W, share, mean.contact.F_W);
      if constexpr (uses<typename S::Joints>) add_share(x.bodies[i].joint.F_C, share, mean.joint.F_C);
    }
    if constexpr (has_stages<S>) w.means.contacts.add(x.forces, share);
    if constexpr (has_stages<S> && uses<NetOf<S>>) w.means.of_nodes.add(x.net.forces, share);
    if constexpr (uses<TermsOf<S>>)
      for (std::size_t t = 0; t < par.terms.size(); ++t)
        add_share(x.terms.list[t], share, w.means.terms.list[t]);
  }
}

/// Multiplies the shares of the stages so far by a factor.
template <Scene S>
void scale_means([[maybe_unused]] const Params<S>& par, [[maybe_unused]] Real factor,
                 [[maybe_unused]] Scratch<S>& w) noexcept {
  if constexpr (has_means<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      auto& mean = w.means.bodies[i];
      const auto scale = [factor](Wrench& F) noexcept { F = {.tau = factor * F.tau, .f = factor * F.f}; };
      if constexpr (uses<ContactsOf<S>>) scale(mean.contact.F_W);
      if constexpr (uses<typename S::Joints>) scale(mean.joint.F_C);
    }
    if constexpr (uses<ContactsOf<S>>) w.means.contacts.scale(factor);
    if constexpr (uses<NetOf<S>>) w.means.of_nodes.scale(factor);
    if constexpr (uses<TermsOf<S>>)
      for (Wrench& F : w.means.terms.list) F = {.tau = factor * F.tau, .f = factor * F.f};
  }
}

/// Copies means.
template <class S>
void assign(const StepMeans<S>& from, StepMeans<S>& to) noexcept {
  to.bodies = from.bodies;
  if constexpr (uses<ContactsOf<S>>) to.contacts.assign(from.contacts);
  if constexpr (uses<NetOf<S>>) to.of_nodes.assign(from.of_nodes);
  if constexpr (uses<TermsOf<S>>) to.terms = from.terms;
}

}  // namespace godobject
