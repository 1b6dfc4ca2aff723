// Reference solution by the core itself, with steps so short that its error is negligible.
#pragma once

#include <stdexcept>
#include <vector>

#include "tests/oracle/solve.h"
#include "tests/study/case_run.h"

namespace godobject::study {

/// Returns the solution of the case at `times` (evenly spaced from 0), with `steps_between` steps of tr-bdf2
/// per interval. t_last: latest time at which the target is evaluated, s. Throws std::runtime_error for a
/// fault.
template <Scene S>
oracle::Solution by_short_steps(const oracle::Case& problem, const std::vector<double>& times,
                                std::size_t steps_between, double t_last) {
  static_assert(S::Integrator::order == 2);
  oracle::Solution solution{.times = times, .states = {}};
  CaseRun<S> run(problem, (times.at(1) - times.at(0)) / static_cast<double>(steps_between));
  for (std::size_t n = 0; n < times.size(); ++n) {
    std::vector<oracle::RigidState>& bodies = solution.states.emplace_back(problem.bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const RigidBodyState& x = run.body(i);
      bodies[i] = {.p = x.X_WB.p, .q = x.X_WB.q, .v = x.v_W, .w = to_world(x.X_WB.q, x.w_B)};
    }
    for (const Input<S>& in : run.inputs(steps_between, t_last, n * steps_between)) run.step(in);
    if (any(run.output().fault)) throw std::runtime_error("the step of a reference reported a fault");
  }
  return solution;
}

}  // namespace godobject::study
