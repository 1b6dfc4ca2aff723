// Implicit Euler, the paper's scheme: first order, one stage.
#pragma once

#include "core/stage.h"

namespace godobject {

struct ImplicitEuler {
  static constexpr const char* name = "implicit-euler";
  static constexpr int order = 1;
  using State = Empty;

  /// One step of all bodies in w.next, towards the targets at the end of the step.
  template <Scene S>
  static void advance(const Params<S>& par, Scratch<S>& w) noexcept {
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      w.bases[i] = w.next.bodies[i].x;
      if constexpr (uses<typename S::Device>) w.targets[i] = w.drives[i].to;
    }
    solve_stage(par, par.h, w);
    for (std::size_t i = 0; i < par.num_bodies; ++i) w.next.bodies[i].x = moved(w.bases[i], w.velocities[i], par.h);
  }
};

}  // namespace godobject
