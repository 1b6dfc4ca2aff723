// Attitude errors of a stage whose turns are counted (16).
#pragma once

#include "core/counted_errors.h"
#include "core/stage_scratch.h"

namespace godobject {

/// Errors of a stage, for TurnCounter.
template <Scene S, class TargetOfGroup>
struct StageErrors {
  const Params<S>& par;
  const TargetOfGroup& target_of;
  Scratch<S>& w;

  Quat q_WB(std::size_t i) const noexcept { return lane(w.bases[i / lanes<S>].X_WB.q, i % lanes<S>); }
  Quat q_WD(std::size_t i) const noexcept { return lane(target_of(i / lanes<S>).X_WD.q, i % lanes<S>); }
  Vec3 phi(std::size_t i) const noexcept { return lane(w.next[i / lanes<S>].coupling.phi_B, i % lanes<S>); }
  Vec3 before(std::size_t i) const noexcept {
    if (w.coupling_inputs[i].fresh) return Vec3::Zero();
    return lane(w.errors.before[i / lanes<S>], i % lanes<S>);
  }
  TurnsAhead& turns(std::size_t i) const noexcept { return w.errors.turns[i]; }
  bool is_coupled(std::size_t i) const noexcept {
    return par.bodies[i].coupling.k_r > 0 && w.coupling_inputs[i].ramp.engaged;
  }
  void set_phi(std::size_t i, const Vec3& phi_B) const noexcept {
    set_lane(w.next[i / lanes<S>].coupling.phi_B, i % lanes<S>, phi_B);
  }
};

/// Counts the turns of the errors of group g and returns their contribution (16). error: short errors,
/// replaced by those on the sides of their parents'.
template <Scene S, class TargetOfGroup>
[[gnu::noinline]] Vector3<Lanes<S>> count_turns(const Params<S>& par, std::size_t g,
                                                const TargetOfGroup& target_of,
                                                RotationErrorOf<Lanes<S>>& error, Scratch<S>& w) noexcept {
  using T = Lanes<S>;
  TurnCounter<S, StageErrors<S, TargetOfGroup>> counter(par, {par, target_of, w});
  Vector3<T> turns_B = Vector3<T>::Zero();
  for (std::size_t j = 0; j < lanes<S> && g * lanes<S> + j < num_bodies(par); ++j) {
    const std::size_t i = g * lanes<S> + j;
    counter.count(i);
    w.errors.has_turns |= w.errors.turns[i].any();
    const Vec3 phi_B = lane(w.next[g].coupling.phi_B, j);
    // the curvature (11) of the long way round is negative, and would add energy
    if (phi_B != lane(error.phi_B, j)) set_lane(error.curvature, j, 0);
    set_lane(error.phi_B, j, phi_B);
    set_lane(turns_B, j, counter.counted(i).turns_B);
  }
  return turns_B;
}

}  // namespace godobject
