// Solution of a stage, from its bases to the velocities at its end, repeated until the joints hold.
#pragma once

#include "core/node_stage.h"
#include "core/step_means.h"
#include "core/tuning.h"

namespace godobject {

/// True if the joints hold at the moved bodies (39). Rotation violates a joint by h |dw| sqrt(h^2 |dw|^2 +
/// h^2 |w+|^2) of a lever. dw: change of w against the velocities from(g) at which the joints were
/// linearised.
template <Scene S, class VelocityOfGroup>
bool joints_hold(const Params<S>& par, Real h, const VelocityOfGroup& from, const Scratch<S>& w) noexcept {
  using T = Lanes<S>;
  Real sum = 0;
  for (std::size_t g = 0; g < num_groups(par); ++g) {
    const Vector3<T>& w_B = w.velocities[g].w_B;
    const T change_sq = (w_B - from(g)).squaredNorm();
    const T violation_sq = change_sq * (change_sq + w_B.squaredNorm());
    for (std::size_t j = 0; j < lanes<S> && g * lanes<S> + j < num_bodies(par); ++j) {
      if constexpr (uses<ContactsOf<S>>)
        if (!w.contacts.graph.joints.joined[g * lanes<S> + j]) continue;
      sum += lane(violation_sq, j);
    }
  }
  return (h * h) * (h * h) * sum <= min_iterated_violation * min_iterated_violation;
}

/// Returned if a joint stop is active. Stops are linearised once per stage; relinearising them may alternate
/// between active and inactive.
inline constexpr int stop_is_active = -1;

/// Iterates the solution over h until the joints hold (39). Returns the number of iterations, more than
/// max_joint_iterations if they do not hold.
template <Scene S, class TargetOfGroup>
int iterate_joints(const Params<S>& par, const State<S>& x, Real h, const TargetOfGroup& target_of,
                   Scratch<S>& w) noexcept {
  for (int k = 1; k <= max_joint_iterations; ++k) {
    w.iteration.linearised = w.velocities;
    solve_once<Solve::again>(par, x, h, target_of, w);
    if (w.tree.stop_acts) return stop_is_active;
    const auto from = [&w](std::size_t g) -> const auto& { return w.iteration.linearised[g].w_B; };
    if (joints_hold(par, h, from, w)) return k;
  }
  return max_joint_iterations + 1;
}

/// True if every joint's violation at the start of the step is below max_apart. Only then may the stage be
/// iterated; larger violations are corrected once, clamped.
template <Scene S>
bool joints_hold_at_start(const Params<S>& par, const State<S>& x) noexcept {
  bool hold = true;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const auto& joint = par.bodies[i].joint;
    if (joint.kind == JointKind::free) continue;
    if constexpr (prescribes<S>) {
      if (joint.motion.prescribed) continue;
    }
    with_joint(joint.kind, [&](auto kind) noexcept {
      const auto m = kind.motion(joint_at(joint, place_of(par, x, joint.parent), place_of(par, x, i)).X);
      const Real e_w_sq = decltype(m)::num_turns < 3 ? m.e_w.squaredNorm() : 0,
                 lever_sq = joint.C.p.squaredNorm();
      hold =
          hold && e_w_sq <= max_apart * max_apart && m.e_v.squaredNorm() <= max_apart * max_apart * lever_sq;
    });
  }
  return hold;
}

/// Begins the contacts of substep k of a stage.
template <Scene S>
void begin_substep([[maybe_unused]] int k, [[maybe_unused]] int substeps, [[maybe_unused]] const auto& stage,
                   [[maybe_unused]] Scratch<S>& w) noexcept {
  if constexpr (uses<ContactsOf<S>>) {
    const auto begin = [k](auto& memories) noexcept {
      k == 0 ? memories.restart() : memories.next_substep();
    };
    w.contacts.stage = stage;
    if (k > 0) w.contacts.stage = {.found = w.contacts.report.found, .continues_step = true};
    w.contacts.stage.relaxation_time = stage.relaxation_time / substeps;
    begin(w.contacts.memories);
    if constexpr (uses<NetOf<S>>) begin(w.contacts.net.memories);
  }
}

/// Sets the bases of another Euler step or substep to the end of the previous one, of length h_1. Adds its
/// forces to the means.
template <Scene S>
void follow_bases(const Params<S>& par, const State<S>& x, Real h_1, Scratch<S>& w) noexcept {
  add_to_means(par, h_1 / par.h, w);
  for (std::size_t g = 0; g < num_groups(par); ++g) w.bases[g] = end_of_stage(par, g, h_1, w);
  follow_coordinates(
      par, h_1, [&w](std::size_t i) { return lane(w.bases[i / lanes<S>], i % lanes<S>); }, w);
  follow_nodes(par, x, h_1, w);
}

/// Solves the stage in as few implicit Euler substeps as make the joints hold (39). Returns the length of a
/// substep, s. w.bases and w.velocities are those of the last substep.
template <Scene S, class TargetOfGroup>
Real solve_substeps(const Params<S>& par, const State<S>& x, Real h, const TargetOfGroup& target_of,
                    Scratch<S>& w) noexcept {
  const auto base = [&w](std::size_t g) -> const auto& { return w.bases[g].w_B; };
  w.iteration.starts = w.bases;
  w.iteration.coordinates = w.tree.q;
  w.iteration.subdivides = true;
  assign(w.means, w.iteration.means);
  keep_node_starts(par, x, w);
  std::conditional_t<uses<ContactsOf<S>>, ContactStage, None> stage;
  if constexpr (uses<ContactsOf<S>>) stage = w.contacts.stage;
  constexpr int limit = uses<NetOf<S>> ? max_substeps_with_nets : max_substeps;
  for (int substeps = substep_ratio;; substeps *= substep_ratio) {
    const Real t = h / substeps;
    const bool is_last = substeps == limit;
    bool hold = true;
    for (int k = 0; k < substeps && (hold || is_last); ++k) {
      if (k > 0) follow_bases(par, x, t, w);
      begin_substep(k, substeps, stage, w);
      if (k == 0) solve_once(par, x, t, target_of, w);
      else solve_once<Solve::first_of_substep>(par, x, t, target_of, w);
      if (joints_hold(par, t, base, w) || w.tree.stop_acts) continue;
      const int iterations = iterate_joints(par, x, t, target_of, w);
      if (iterations == stop_is_active) solve_once<Solve::first_of_substep>(par, x, t, target_of, w);
      hold = iterations <= max_joint_iterations;
    }
    if (hold || is_last) return t;
    w.bases = w.iteration.starts;
    w.tree.q = w.iteration.coordinates;
    assign(w.iteration.means, w.means);
    restore_node_starts(par, x, w);
  }
}

/// Outcome of a stage solve.
struct StageEnd {
  bool solved = true;  // false if the joints did not converge and substeps were not allowed
  bool acceleration_valid =
      true;  // false if joint forces jumped in this stage, so that its accelerations do not extrapolate
  Real h;    // s, from w.bases to the end; shorter than a subdivided stage (39)
};

/// Completes a stage whose joints do not hold after one solve. Not inlined: keeps it out of the hot path.
template <Scene S, class TargetOfGroup>
[[gnu::noinline]] StageEnd solve_until_joints_hold(const Params<S>& par, const State<S>& x, Real h,
                                                   bool may_subdivide, const TargetOfGroup& target_of,
                                                   Scratch<S>& w) noexcept {
  if (w.tree.stop_acts || !joints_hold_at_start(par, x)) return {.h = h};
  const int iterations = iterate_joints(par, x, h, target_of, w);
  if (iterations == stop_is_active) {
    solve_once(par, x, h, target_of, w);
    return {.h = h};
  }
  if (iterations <= max_joint_iterations) return {.acceleration_valid = iterations == 1, .h = h};
  if (!may_subdivide) return {.solved = false, .acceleration_valid = false, .h = h};
  return {.acceleration_valid = false, .h = solve_substeps(par, x, h, target_of, w)};
}

/// True if a body's solved motion leaves the region in which its contacts were searched. Checked for bodies
/// that move farther than predicted or have no contact force.
template <Scene S>
[[gnu::noinline]] bool ends_outside_search(const Params<S>& par, Real h, bool may_be_held,
                                           const Scratch<S>& w) noexcept {
  const auto& finder = w.contacts.finder;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const auto& owned = finder.owned[i];
    const Twist V{.w = w.contacts.x.V[i].w.vec(), .v = w.contacts.x.V[i].v.vec()},
        &predicted = finder.at[i].V;
    const Twist beyond{.w = V.w - predicted.w, .v = V.v - predicted.v};
    if (!is_outside_search(owned, owned.beyond_predicted, h) || !is_outside_search(owned, beyond, h))
      continue;
    const Wrench& F = w.contacts.wrenches[i];
    const bool is_held = F.f.squaredNorm() + F.tau.squaredNorm() > 0;
    const Real farther = speed_bound(V, owned.farthest) - speed_bound(predicted, owned.farthest);
    if (may_be_held || !is_held || h * farther > owned.smallest) return true;
  }
  return false;
}

/// Solves the stage over h from w.bases. may_subdivide: the stage is an implicit Euler step.
template <Scene S, class TargetOfGroup>
StageEnd solve_stage(const Params<S>& par, const State<S>& x, Real h, [[maybe_unused]] bool may_subdivide,
                     const TargetOfGroup& target_of, Scratch<S>& w) noexcept {
  solve_once(par, x, h, target_of, w);
  if constexpr (uses<ContactsOf<S>>) {
    // second-order stages have no straight path along which contacts could be searched
    if (w.contacts.finder.may_leave_search && ends_outside_search(par, h, !may_subdivide, w)) [[unlikely]] {
      if (!may_subdivide) return {.solved = false, .acceleration_valid = false, .h = h};
      solve_once<Solve::again>(par, x, h, target_of, w);
    }
  }
  if constexpr (iterates_joints<S>) {
    const auto base = [&w](std::size_t g) -> const auto& { return w.bases[g].w_B; };
    if (!joints_hold(par, h, base, w)) [[unlikely]]
      return solve_until_joints_hold(par, x, h, may_subdivide, target_of, w);
  }
  return {.h = h};
}

}  // namespace godobject
