// Drawn walls on one axis, and the bounds of the energy that they may give.
#pragma once

#include <array>
#include <cmath>
#include <random>

#include "tests/support/sampled_wall.h"

namespace godobject {

/// Bounds of the energy that a controlled axis gives, J: docs/theory/passivity.md. The first holds for forces
/// up to 5 N on most axes, the second beside the energy of the softened spring.
inline constexpr double margin_J = 5e-3, least_margin_J = 1e-3;

inline SampledWall without_controller(SampledWall wall) {
  wall.energy_J = 0;
  return wall;
}

/// Draws a wall. force: of the hand, N.
inline SampledWall drawn_wall(std::mt19937& random, double& force) {
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  const auto scale = [&](double a, double b) { return a * std::pow(b / a, between(0, 1)); };
  SampledWall wall;
  wall.plant.inertia = scale(0.02, 1);
  wall.plant.damping = scale(0.05, 5);
  wall.stiffness = scale(500, 40e3);
  wall.delay = static_cast<int>(between(0, 3));
  wall.count = scale(1e-6, 50e-6);
  wall.period_s = std::array{2.5e-4, 5e-4, 1e-3, 2e-3}[static_cast<std::size_t>(between(0, 4))];
  const bool held = between(0, 3) < 2;
  wall.plant.hand_stiffness = held ? scale(50, 2000) : 0;
  wall.plant.hand_damping = held ? scale(0.5, 20) : 0;
  wall.q_start = between(-5e-3, 0);
  force = between(0.5, 5);
  return wall;
}

/// Returns the energy of the softened spring under the hand's force, J. The axis lifts the hand by as much
/// while it converges to the wall's law.
inline double softened_J(const SampledWall& wall, double force) {
  const double reach_s = (wall.delay + 1) * wall.period_s;
  return force * force /
         (2 * PassivityController::stiffness_share * wall.plant.inertia / (reach_s * reach_s));
}

}  // namespace godobject
