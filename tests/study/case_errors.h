// Errors of a run of a scene relative to its reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "tests/oracle/solve.h"
#include "tests/study/case_run.h"
#include "tests/study/reference_scene.h"

namespace godobject::study {

inline constexpr double comparison_step = 4e-3;  // s: divisible by every step of the study

/// Largest differences from the reference over all bodies, at multiples of 4 ms from the scene's `from` on.
struct Errors {
  double position = 0;             // m
  double rotation = 0;             // angle between the attitudes, rad
  std::optional<double> energy;    // for a free body: |E(t) / E(0) - 1|
  std::optional<double> momentum;  // for a free body: |L(t) - L(0)| / |L(0)|, angular momentum in world axes
  std::optional<Drift> drift;      // drift of the joints, after every step
};

inline std::size_t steps_in(double duration, double h) {
  return static_cast<std::size_t>(std::lround(duration / h));
}

inline double angle_between(const Quat& a, const Quat& b) {
  const Quat difference = a.conjugate() * b;
  return 2 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

inline Vec3 angular_momentum(const RigidBodyParams& par, const RigidBodyState& x) {
  return to_world(x.X_WB.q, par.I_B * x.w_B);
}

/// True if no forces act, only inertia.
template <Scene S>
inline constexpr bool is_inertial = !uses<typename S::Coupling> && !uses<typename S::Joints>;

/// Updates the worst errors with those of one instant.
template <Scene S>
void compare(const CaseRun<S>& run, const std::vector<oracle::RigidState>& exact, Errors& worst) {
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const Pose& X = run.body(i).X_WB;
    worst.position = std::max(worst.position, (X.p - exact[i].p).norm());
    worst.rotation = std::max(worst.rotation, angle_between(X.q, Quat(exact[i].q)));
  }
}

/// Runs the scene once and compares it with the reference. Throws std::runtime_error for a fault.
template <Scene S>
Errors compare(const ReferenceScene& scene, const oracle::Solution& reference, CaseRun<S>& run, double h) {
  const RigidBodyParams& body = run.params().bodies[0].body;
  const double E_0 = run.kinetic();
  const Vec3 L_0 = angular_momentum(body, run.body(0));
  const auto every = static_cast<std::size_t>(std::lround(comparison_step / h));
  const std::vector<Input<S>> inputs = run.inputs(steps_in(scene.duration, h), scene.duration);

  Errors worst;
  if constexpr (is_inertial<S>) worst.energy = worst.momentum = 0;
  if constexpr (uses<typename S::Joints>) worst.drift = Drift{};
  for (std::size_t n = 1; n <= inputs.size(); ++n) {
    run.step(inputs[n - 1]);
    if (any(run.output().fault)) throw std::runtime_error(scene.name + ": the step reported a fault");
    if constexpr (uses<typename S::Joints>) worst.drift = godobject::worst(*worst.drift, run.drift());
    if (n % every != 0 || n / every >= reference.times.size() || reference.times[n / every] < scene.from)
      continue;
    compare(run, reference.states[n / every], worst);
    if constexpr (is_inertial<S>) {
      worst.energy = std::max(*worst.energy, std::abs(run.kinetic() / E_0 - 1));
      worst.momentum =
          std::max(*worst.momentum, (angular_momentum(body, run.body(0)) - L_0).norm() / L_0.norm());
    }
  }
  return worst;
}

}  // namespace godobject::study
