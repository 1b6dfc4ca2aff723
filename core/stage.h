// One stage of an integrator: from the bases of all bodies to the velocities they move with.
#pragma once

#include "core/device.h"
#include "core/gather.h"
#include "core/implicit_stage.h"
#include "core/tree.h"

namespace godobject {

/// What the bodies of a scene are worked on with: one by one, or by groups of four where there are more than two. A
/// scene may say which with `using Number = Real;` or Pack.
template <class S>
struct NumberOf {
  using type = std::conditional_t<(S::max_bodies > 2), Pack, Real>;
};
template <class S>
requires requires { typename S::Number; }
struct NumberOf<S> {
  using type = typename S::Number;
};
template <class S>
using Lanes = typename NumberOf<S>::type;
template <class S>
using GroupIn = Group<Lanes<S>>;
template <class S>
inline constexpr std::size_t lanes = num_lanes<Lanes<S>>;
template <class S>
inline constexpr std::size_t max_groups = (S::max_bodies + lanes<S> - 1) / lanes<S>;
template <class S>
constexpr std::size_t num_groups(const Params<S>& par) noexcept {
  return (num_bodies(par) + lanes<S> - 1) / lanes<S>;
}

/// Of a group's state, what a step computes before it is known to be good.
template <class S>
struct Next {
  using T = Lanes<S>;
  RigidBodyStateOf<T> x;
  [[no_unique_address]] Slot<typename S::Integrator::template MemoryOf<T>, 0> memory;
  [[no_unique_address]] Slot<typename S::Coupling::template StateOf<T>, 1> coupling;
};

/// Joints of the scene may follow the device.
template <class S>
inline constexpr bool imposes = !std::is_empty_v<typename S::Joints::Input>;

/// Worthless between steps.
template <class S>
struct Scratch {
  using T = Lanes<S>;
  std::array<Pull, S::max_bodies> pulls;                     // from the devices
  std::array<Next<S>, max_groups<S>> next;                   // committed if finite
  std::array<TargetOf<T>, max_groups<S>> inside;             // targets inside the step
  std::array<RigidBodyStateOf<T>, max_groups<S>> bases;      // where the stage starts
  std::array<StageVelocityOf<T>, max_groups<S>> velocities;  // what the stage solves for
  [[no_unique_address]] std::conditional_t<uses<typename S::Joints>, Tree<S::max_bodies, typename S::Joints>,
                                           Absent<4>>
      tree;  // the bodies with their joints
  [[no_unique_address]] std::conditional_t<uses<typename S::Joints> && uses<typename S::Feedback>,
                                           std::array<Wrench, S::max_bodies>, Absent<2>>
      wanted;  // to be shown on the links of the device, before limits
  [[no_unique_address]] std::conditional_t<imposes<S>, std::array<Lead, S::max_bodies>, Absent<6>> leads;
};

/// The attitude errors of the step before, by which a stage keeps its side near the half turn.
template <Scene S>
void recall_errors(const GroupIn<S>& group, const State<S>& x, Next<S>& next) noexcept {
  if constexpr (uses<typename S::Coupling>)
    next.coupling.phi_B =
        gathered(group, [&](std::size_t i) -> const Vec3& { return x.bodies[i].coupling.phi_B; });
}

/// Solves (10) and (11) for every body over a time h from w.bases; target_of(g) are the targets of group g at the
/// end of the stage. w.next holds the attitude error of the stage before, then of this one.
template <Scene S, class TargetOfGroup>
void solve_stage(const Params<S>& par, const State<S>& x, Real h, const TargetOfGroup& target_of,
                 Scratch<S>& w) noexcept {
  using T = Lanes<S>;
  for (std::size_t g = 0; g < num_groups(par); ++g) {
    const GroupIn<S> group(g, num_bodies(par));
    const RigidBodyParamsOf<T>& body =
        gathered(group, [&](std::size_t i) -> const RigidBodyParams& { return par.bodies[i].body; });
    const RigidBodyStateOf<T>& base = w.bases[g];
    Vector3<T> F_W = body.m * par.gravity_W;
    Vector3<T> tau_B = Vector3<T>::Zero();
    if constexpr (uses<typename S::Device>) {
      F_W += gathered(group, [&](std::size_t i) -> const Vec3& { return w.pulls[i].F_WB.f; });
      tau_B = to_body<T>(base.X_WB.q,
                         gathered(group, [&](std::size_t i) -> const Vec3& { return w.pulls[i].F_WB.tau; }));
    }

    SpringParamsOf<T> spring;
    Vector3<T> e_W = Vector3<T>::Zero(), v_D = Vector3<T>::Zero(), w_D_B = Vector3<T>::Zero();
    RotationErrorOf<T> error;
    if constexpr (uses<typename S::Coupling>) {
      const TargetOf<T>& target = target_of(g);
      spring =
          gathered(group, [&](std::size_t i) { return ramped(par.bodies[i].coupling, w.pulls[i].ramp.s); });
      e_W = target.X_WD.p - base.X_WB.p;
      v_D = target.V_WD.v;
      w_D_B = to_body<T>(base.X_WB.q, target.V_WD.w);
      error = rotation_error<T>(base.X_WB.q, target.X_WD.q, w.next[g].coupling.phi_B);
      w.next[g].coupling.phi_B = error.phi_B;
    }

    const TranslationSystemOf<T> translation =
        implicit_translation(body.m, spring, base.v_W, e_W, v_D, F_W, h);
    const RotationSystemOf<T> rotation = implicit_rotation(body, spring, base.w_B, error, w_D_B, tau_B, h);
    if constexpr (uses<typename S::Joints>) {
      load(par, g, base, translation, rotation, h, w.tree);
    } else {
      w.velocities[g] = {.v_W = translation.b_W * T(1 / translation.M),
                         .w_B = solve3<T>(rotation.A_B, rotation.b_B)};
    }
  }
  if constexpr (uses<typename S::Joints>) {
    w.tree.stiff_stop = false;
    for (std::size_t i = num_bodies(par); i-- > 0;)
      eliminate(par.bodies[i].joint, i, x.bodies[i].joint.f_C, h, w.tree);
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const StageVelocity V = solve_back(par.bodies[i].joint, i, h, w.tree);
      set_lane(w.velocities[i / lanes<S>].v_W, i % lanes<S>, V.v_W);
      set_lane(w.velocities[i / lanes<S>].w_B, i % lanes<S>, V.w_B);
    }
  }
}

/// Imposed joints at the fraction s of the step: where the coming stage is to lead them.
template <Scene S>
void lead_joints(const Params<S>& par, Real s, Scratch<S>& w) noexcept {
  if constexpr (imposes<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) w.tree.led[i] = interpolated(w.leads[i], s, par.h);
  }
}

/// The targets at the end of the step.
template <Scene S>
auto targets_at_the_end(const Params<S>& par, const Scratch<S>& w) noexcept {
  return [&](std::size_t g) -> decltype(auto) {
    return gathered(GroupIn<S>(g, num_bodies(par)),
                    [&w](std::size_t i) -> const Target& { return w.pulls[i].to; });
  };
}

/// The bodies at the end of a stage.
template <class T>
RigidBodyStateOf<T> moved(const RigidBodyStateOf<T>& base, const StageVelocityOf<T>& V, Real h) noexcept {
  return {.X_WB = moved<T>(base.X_WB, V.v_W, V.w_B, h), .v_W = V.v_W, .w_B = V.w_B};
}

}  // namespace godobject
