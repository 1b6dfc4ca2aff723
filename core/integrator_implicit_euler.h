// Implicit Euler, the paper's scheme: first order, one stage.
#pragma once

#include "core/node_stage.h"
#include "core/solve_stage.h"

namespace godobject {

struct ImplicitEuler {
  static constexpr const char* name = "implicit-euler";
  static constexpr int order = 1;
  template <class>
  using MemoryOf = Empty;
  using Memory = Empty;
  using NodeMemory = Empty;

  /// Advances all bodies by one step, from x to w.next, towards the targets at the end of the step.
  template <Scene S>
  static Limited advance(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    for (std::size_t g = 0; g < num_groups(par); ++g) {
      const GroupIn<S> group(g, num_bodies(par));
      w.bases[g] = gathered(group, [&](std::size_t i) -> const RigidBodyState& { return x.bodies[i].x; });
      recall_errors<S>(group, x, w.next[g]);
    }
    start_nodes(par, x, 0, w);
    start_coordinates(par, x, w);
    prescribe_joints(par, 1, w);
    prescribe_forces(par, 1, w);
    begin_stage<S>({.relaxation_time = par.h}, x, w);
    begin_means(par, x, 0, w);
    const StageEnd end = solve_stage(par, x, par.h, true, targets_at_the_end(par, w), w);
    for (std::size_t g = 0; g < num_groups(par); ++g) w.next[g].x = end_of_stage(par, g, end.h, w);
    end_coordinates(par, end.h, w);
    end_nodes(par, x, end.h, w);
    add_to_means(par, end.h / par.h, w);
    return Limited::none;
  }
};

}  // namespace godobject
