// A wall rendered on one simulated axis (sim/rig/plant.h): sampled, rounded to counts, delayed, held.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "hal/rig/passivity_controller.h"
#include "platform/session/passivity.h"
#include "sim/rig/plant.h"

namespace godobject {

/// A slider that a constant force of the hand presses against a wall at q = 0. The defaults are those of the
/// issue's device: it buzzes without a controller.
struct SampledWall {
  JointPlant plant{.inertia = 0.05, .damping = 0.5, .friction = 0, .hand_stiffness = 0, .hand_damping = 5};
  double stiffness = 20e3;                                      // N/m
  double period_s = 1e-3;                                       // a multiple of SimPlant::substep_ns
  int delay = 1;                                                // periods from the sample to the force
  double count = 10e-6;                                         // m
  double force_rate = std::numeric_limits<double>::infinity();  // N/s, of the force that is sent
  double energy_J = PassivityParams{}.energy_J;                 // 0: no controller
  double q_start = -2e-3;
  double known_inertia = 1;  // inertia known to the controller, of the true one
  double ahead_s = 0;        // s, over which the law predicts the sample
  // Law that displays the wall, made for a run: from the sample q, m, to the force, N. None: the spring.
  std::function<std::function<double(double q)>(const SampledWall&)> law{};

  PassivityParams controller() const noexcept {
    const SampledAxis axis{.inertia = plant.inertia,
                           .damping = plant.damping,
                           .K = stiffness,
                           .B = ahead_s * stiffness,
                           .period_s = period_s,
                           .delay = delay};
    return {.inertia = known_inertia * plant.inertia,
            .damping = plant.damping,
            .needed = axis.needed(),
            .stiffness = stiffness,
            .resolution = count,
            .period_s = period_s,
            .delay = delay,
            .acts_after = delay,
            .energy_J = energy_J};
  }
};

struct WallRun {
  double given_J = 0;             // J, maximum of the work of the force less the dissipation of the device
  double ripple = 0;              // N, peak to peak of the force that acts in the last half second
  double mean_force = 0;          // N, mean of the same
  double law_force = 0;           // N, mean of the wall's law there
  double largest_step = 0;        // N, largest change of the force sent from one period to the next
  double largest_free_force = 0;  // N, while the axis is out of the wall, after the delay
  double generated_J = 0;         // of the observer, at the end
  bool finite = true;
};

/// Runs for time_s. push(t): force of the hand, N, towards the wall if positive.
template <class Push>
WallRun run_wall(const SampledWall& wall, double time_s, Push push) {
  SimPlant plant({wall.plant}, true, JointVector::Constant(1, wall.q_start), 0);
  PassivityController controller(wall.controller());
  std::vector<double> pending(static_cast<std::size_t>(wall.delay) + 1, 0);
  const JointVector rest = JointVector::Zero(1);
  const auto period_ns = static_cast<Nanoseconds>(std::llround(1e9 * wall.period_s));
  const auto num_periods = static_cast<int>(std::lround(time_s / wall.period_s));
  const int num_last = static_cast<int>(std::lround(0.5 / wall.period_s));
  std::function<double(double)> law = [&](double q) { return q > 0 ? -wall.stiffness * q : 0; };
  if (wall.law) law = wall.law(wall);
  WallRun run;
  double energy = 0, last = 0, low = 1e300, high = -1e300;
  int free_periods = 0;
  for (int k = 0; k < num_periods; ++k) {
    const double t = k * wall.period_s, true_q = plant.q()(0);
    const double q = std::round(true_q / wall.count) * wall.count;
    const double wanted = controller.limit(law(q), q, true);
    const double change = wall.force_rate * wall.period_s;
    const double sent = std::clamp(wanted, last - change, last + change);
    controller.sent(sent);
    run.largest_step = std::max(run.largest_step, std::abs(sent - last));
    last = sent;
    pending[static_cast<std::size_t>(k + wall.delay) % pending.size()] = sent;
    const double acts = pending[static_cast<std::size_t>(k) % pending.size()];
    free_periods = q > 0 ? 0 : free_periods + 1;
    if (free_periods > wall.delay + 1)
      run.largest_free_force = std::max(run.largest_free_force, std::abs(acts));
    plant.set_motor_torque(0, acts + push(t));
    for (Nanoseconds ns = SimPlant::substep_ns; ns <= period_ns; ns += SimPlant::substep_ns) {
      const double before = plant.q()(0);
      plant.advance(k * period_ns + ns, rest, rest);
      const double v = plant.q_dot()(0);
      energy += acts * (plant.q()(0) - before) - wall.plant.damping * v * v * 1e-9 * SimPlant::substep_ns;
    }
    run.given_J = std::max(run.given_J, energy);
    run.finite = std::abs(plant.q()(0)) < 1;
    if (!run.finite) break;
    if (k < num_periods - num_last) continue;
    low = std::min(low, acts);
    high = std::max(high, acts);
    run.mean_force += acts / num_last;
    run.law_force += std::min(0.0, -wall.stiffness * true_q) / num_last;
  }
  run.ripple = high - low;
  run.generated_J = controller.energy_J();
  return run;
}

/// Returns a force that rises to `force` within time_s, without a corner at its ends.
inline double eased(double force, double t, double time_s) {
  const double s = std::clamp(t / time_s, 0.0, 1.0);
  return force * s * s * (3 - 2 * s);
}

}  // namespace godobject
