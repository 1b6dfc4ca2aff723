// Scenes of the extreme cases: bodies held by targets, and how fast they are.
#pragma once

#include "tests/study/map/cases.h"
#include "tests/study/map/scenes.h"
#include "tests/study/map/watched_run.h"

namespace godobject::study {

template <Scene S>
void hold(Running<S>& run, std::size_t i, const Pose& X_WD) {
  run.par.bodies[i].device.rise = 0;
  engage_at<S>(run.x, i, {.X_WD = X_WD, .V_WD = {}});
  run.in.devices[i].target = {.X_WD = X_WD, .V_WD = {}};
}

/// Speed of the fastest point of a body 0.1 m from its centre, m/s.
template <Scene S>
Real fastest(const Running<S>& run) {
  Real most = 0;
  for (std::size_t i = 0; i < num_bodies(run.par); ++i)
    most = std::max(most, run.x.bodies[i].x.v_W.norm() + 0.1 * run.x.bodies[i].x.w_B.norm());
  return most;
}

/// Runs the steps without moving the targets.
template <Scene S>
void rest(Running<S>& run, int steps, CaseResult& result) {
  watch(
      run, steps, [&](int) { run.step(); }, result.run);
}

}  // namespace godobject::study
