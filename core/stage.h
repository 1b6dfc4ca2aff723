// One stage of an integrator: from the bases of all bodies to the velocities they move with.
#pragma once

#include "core/device.h"
#include "core/implicit_stage.h"
#include "core/tree.h"

namespace godobject {

/// Of a body's state, what a step computes before it is known to be good.
template <class S>
struct NextBody {
  RigidBodyState x;
  [[no_unique_address]] Slot<typename S::Integrator::Memory, 0> memory;
  [[no_unique_address]] Slot<typename S::Coupling::State, 1> coupling;
};

/// Joints of the scene may follow the device.
template <class S>
inline constexpr bool imposes = !std::is_empty_v<typename S::Joints::State>;

/// Worthless between steps.
template <class S>
struct Scratch {
  std::array<NextBody<S>, S::max_bodies> next;          // committed if finite
  std::array<Pull, S::max_bodies> pulls;                // from the devices
  std::array<Target, S::max_bodies> inside;             // targets inside the step
  std::array<RigidBodyState, S::max_bodies> bases;      // where the stage starts
  std::array<StageVelocity, S::max_bodies> velocities;  // what the stage solves for
  [[no_unique_address]] std::conditional_t<uses<typename S::Joints>, Tree<S::max_bodies, typename S::Joints>,
                                           Absent<4>>
      tree;  // the bodies with their joints
  [[no_unique_address]] std::conditional_t<imposes<S>, std::array<Lead, S::max_bodies>, Absent<6>> leads;
};

/// Solves (10) and (11) for every body over a time h from w.bases; target_of(i) is the target of body i at the end
/// of the stage. w.next holds the attitude error of the stage before, then of this one.
template <Scene S, class TargetOf>
void solve_stage(const Params<S>& par, Real h, const TargetOf& target_of, Scratch<S>& w) noexcept {
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const RigidBodyParams& body = par.bodies[i].body;
    const RigidBodyState& base = w.bases[i];
    Wrench F = {.tau = Vec3::Zero(), .f = body.m * par.gravity_W};
    if constexpr (uses<typename S::Device>) {
      F.f += w.pulls[i].F_WB.f;
      F.tau = to_body(base.X_WB.q, w.pulls[i].F_WB.tau);
    }

    SpringParams spring;
    Vec3 e_W = Vec3::Zero(), v_D = Vec3::Zero(), w_D_B = Vec3::Zero();
    RotationError error;
    if constexpr (uses<typename S::Coupling>) {
      const Target& target = target_of(i);
      spring = ramped(par.bodies[i].coupling, w.pulls[i].ramp.s);
      e_W = target.X_WD.p - base.X_WB.p;
      v_D = target.V_WD.v;
      w_D_B = to_body(base.X_WB.q, target.V_WD.w);
      error = rotation_error(base.X_WB.q, target.X_WD.q, w.next[i].coupling.phi_B);
      w.next[i].coupling.phi_B = error.phi_B;
    }

    const TranslationSystem translation = implicit_translation(body.m, spring, base.v_W, e_W, v_D, F.f, h);
    const RotationSystem rotation = implicit_rotation(body, spring, base.w_B, error, w_D_B, F.tau, h);
    if constexpr (uses<typename S::Joints>) {
      load(par.bodies[i].joint, base, translation, rotation, h, w.tree.nodes[i]);
      if constexpr (S::Joints::Stabilisation::uses_base) w.tree.bases[i] = place(base);
    } else {
      w.velocities[i] = {.v_W = translation.b_W * (1 / translation.M),
                         .w_B = solve3(rotation.A_B, rotation.b_B)};
    }
  }
  if constexpr (uses<typename S::Joints>) {
    for (std::size_t i = num_bodies(par); i-- > 0;) eliminate(par.bodies[i].joint, i, h, w.tree);
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      w.velocities[i] = solve_back(par.bodies[i].joint, i, h, w.tree);
  }
}

/// Imposed joints at the fraction s of the step: where the coming stage is to lead them.
template <Scene S>
void lead_joints(const Params<S>& par, Real s, Scratch<S>& w) noexcept {
  if constexpr (imposes<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      w.tree.led[i] = interpolated(w.leads[i], s, par.h);
  }
}

/// The bodies at the end of a stage.
inline RigidBodyState moved(const RigidBodyState& base, const StageVelocity& V, Real h) noexcept {
  return {.X_WB = moved(base.X_WB, V.v_W, V.w_B, h), .v_W = V.v_W, .w_B = V.w_B};
}

}  // namespace godobject
