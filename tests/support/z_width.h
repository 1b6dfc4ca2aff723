// Z-width: the stiffest wall that a simulated axis displays without giving energy.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "tests/support/drawn_wall.h"
#include "tests/support/wall_laws.h"

namespace godobject {

/// Last stiffness of the grid, N/m, at which one count of 10 um is 10 kN: more than any drive displays.
inline constexpr double z_width_end_N_per_m = 1e9;

/// Returns the stiffnesses of the grid, N/m: six in a decade.
inline std::vector<double> z_width_grid() {
  std::vector<double> grid;
  for (double decade = 100; decade < z_width_end_N_per_m; decade *= 10)
    for (const double factor : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) grid.push_back(factor * decade);
  grid.push_back(z_width_end_N_per_m);
  return grid;
}

/// Returns the stiffest wall of the grid up to which all give no more than the margin, N/m; 0: none does. The
/// hand presses with 2 N.
inline double stiffest(SampledWall wall) {
  double last = 0;
  for (const double stiffness : z_width_grid()) {
    wall.stiffness = stiffness;
    const WallRun run = run_wall(wall, 3, [](double) { return 2.0; });
    if (!run.finite || run.given_J > margin_J) break;
    last = stiffness;
  }
  return last;
}

/// Place of the map: an axis of 0.05 kg without a hand.
struct ZWidthPlace {
  double damping = 0.5;  // b, N s/m
  int delay = 1;         // d, periods
  double count = 10e-6;  // m
  double period_s = 1e-3;

  SampledWall wall() const {
    SampledWall wall;
    wall.plant.damping = damping;
    wall.plant.hand_damping = 0;
    wall.delay = delay;
    wall.count = count;
    wall.period_s = period_s;
    return wall;
  }
  /// Returns the stiffest passive wall in continuous coordinates, b / (T/2 + t_d), N/m.
  double colgate() const { return damping / (period_s * (0.5 + delay)); }
};

/// Returns the places of the published map: over damping, delay, counts and rate.
inline std::vector<ZWidthPlace> z_width_places() {
  return {{.damping = 0.5},
          {.damping = 2},
          {.damping = 10},
          {.damping = 2, .delay = 0},
          {.damping = 2, .delay = 2},
          {.damping = 2, .count = 1e-6},
          {.damping = 2, .count = 100e-6},
          {.damping = 2, .period_s = 2e-3},
          {.damping = 2, .period_s = 2.5e-4}};
}

/// Stiffest walls of one place, N/m.
struct ZWidthRow {
  double spring = 0, controlled = 0;  // sampled spring, without and with the controller
  std::vector<double> laws{};         // of wall_laws(), without the controller
};

inline ZWidthRow z_width_row(const ZWidthPlace& place) {
  SampledWall wall = place.wall();
  ZWidthRow row{.spring = stiffest(without_controller(wall)), .controlled = stiffest(wall)};
  for (const auto& [name, law] : wall_laws()) {
    wall.law = law;
    row.laws.push_back(stiffest(without_controller(wall)));
  }
  return row;
}

}  // namespace godobject
