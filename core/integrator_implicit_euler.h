// Implicit Euler, the paper's scheme: first order, one stage.
#pragma once

#include "core/stage.h"

namespace godobject {

struct ImplicitEuler {
  static constexpr const char* name = "implicit-euler";
  static constexpr int order = 1;
  using Memory = Empty;

  /// One step of all bodies from x to w.next, towards the targets at the end of the step.
  template <Scene S>
  static void advance(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      w.bases[i] = x.bodies[i].x;
      w.next[i].coupling = x.bodies[i].coupling;
    }
    const auto at_the_end = [&w](std::size_t i) -> const Target& { return w.pulls[i].to; };
    lead_joints(par, 1, w);
    solve_stage(par, par.h, at_the_end, w);
    for (std::size_t i = 0; i < num_bodies(par); ++i) w.next[i].x = moved(w.bases[i], w.velocities[i], par.h);
  }
};

}  // namespace godobject
