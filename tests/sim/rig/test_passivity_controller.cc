// The passivity controller on a simulated axis that renders a wall.
#include "hal/rig/passivity_controller.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <random>

#include "tests/support/sampled_wall.h"
#include "tests/support/wall_laws.h"

namespace godobject::test_passivity_controller {
namespace {

/// Bounds of the energy that a controlled axis gives, J: docs/theory/passivity.md. The first holds for forces
/// up to 5 N on most axes, the second beside the energy of the softened spring.
constexpr double margin_J = 5e-3, least_margin_J = 1e-3;

SampledWall without_controller(SampledWall wall) {
  wall.energy_J = 0;
  return wall;
}

TEST(PassivityController, AWallThatBuzzesIsQuietWithIt) {
  const SampledWall wall;
  const auto push = [](double t) { return eased(5, t, 2); };
  const WallRun without = run_wall(without_controller(wall), 5, push), with = run_wall(wall, 5, push);
  EXPECT_GT(without.ripple, 10);
  EXPECT_GT(without.given_J, 1);
  EXPECT_LT(with.ripple, 0.1);
  EXPECT_LT(with.given_J, margin_J);
}

TEST(PassivityController, APressedWallShowsItsSteadyForce) {
  for (const double hand_damping : {0.0, 1.0, 5.0, 10.0}) {
    SampledWall wall;
    wall.plant.hand_damping = hand_damping;
    const WallRun run = run_wall(wall, 5, [](double t) { return eased(5, t, 2); });
    EXPECT_NEAR(run.mean_force, run.law_force, 0.02 * 5) << hand_damping;
    EXPECT_NEAR(run.mean_force, -5, 0.02 * 5) << hand_damping;
    EXPECT_LE(run.ripple, 0.105) << hand_damping;
  }
}

TEST(PassivityController, AnImpactComesToRest) {
  const WallRun run = run_wall(SampledWall{}, 3, [](double) { return 2.0; });
  EXPECT_LT(run.ripple, 0.1);
  EXPECT_LT(run.given_J, margin_J);
}

TEST(PassivityController, FreeMotionAddsNoForce) {
  // touches the wall for a second, is pulled off and moves freely
  SampledWall wall;
  const WallRun run = run_wall(wall, 3, [](double t) { return t < 1 ? 2.0 : std::sin(20 * t) - 0.2; });
  EXPECT_LT(run.largest_free_force, 0.01);
}

TEST(PassivityController, AnAxisWithinItsMarginIsLeftUnchanged) {
  // b > K (T/2 + t_d): whatever moves it
  PassivityController controller({.damping = 3.1, .needed = 3, .resolution = 1e-6});
  EXPECT_FALSE(controller.limit(1, 0, true) != 1);
  std::mt19937 random(1);
  std::normal_distribution<double> any;
  for (int k = 0; k < 1000; ++k) {
    const double wanted = any(random);
    EXPECT_EQ(controller.limit(wanted, any(random), k % 7 != 0), wanted);
    controller.sent(wanted);
  }
  EXPECT_EQ(controller.energy_J(), 0);
}

TEST(PassivityController, DissipationIsNotStored) {
  // a second of pure drag, then a spring that generates: the controller acts at the same time as without
  const auto periods_to_act = [](int drag) {
    PassivityController controller({.needed = 30, .resolution = 1e-6});
    double q = 0;
    for (int k = 0; k < drag; ++k) {
      q += 1e-4;
      controller.sent(controller.limit(-1, q, true));
    }
    for (int k = 0; k < 1000; ++k) {
      q += 1e-5;
      controller.limit(-1, q, true);
      controller.sent(1);  // a bus that sends the opposite
      if (controller.share() >= 1) return k;
    }
    return -1;
  };
  EXPECT_GT(periods_to_act(0), 0);
  EXPECT_NEAR(periods_to_act(1000), periods_to_act(0), 2);
}

TEST(PassivityController, MissingSamplesAreMetWithTheMeanOfTheTorque) {
  // 8 periods at a torque of 0 and of 2 in turn, sampled at once, are as 8 periods at 1
  PassivityController controller({.needed = 30, .resolution = 1e-6, .acts_after = 0});
  controller.limit(0, 0, true);
  for (int k = 0; k < 8; ++k) {
    controller.sent(k % 2 == 0 ? 0 : 2);
    controller.limit(0, k == 7 ? 1e-6 : 0, k == 7);
  }
  EXPECT_NEAR(controller.energy_J(), 1e-6, 1e-12);
}

TEST(PassivityController, ResetForgetsEnergyAndSamples) {
  PassivityController controller({.needed = 30, .resolution = 1e-6, .acts_after = 0});
  controller.limit(1, 0, true);
  controller.sent(5);
  controller.limit(1, 1e-3, true);
  EXPECT_GT(controller.energy_J(), 0);
  EXPECT_EQ(controller.share(), 1);
  controller.reset();
  EXPECT_EQ(controller.energy_J(), 0);
  EXPECT_EQ(controller.limit(1, -0.5, true), 1);  // the way from the last sample is not work
  EXPECT_EQ(controller.energy_J(), 0);
}

TEST(PassivityController, ALimitedRateIsKeptAndSeen) {
  SampledWall wall;
  wall.force_rate = 200;
  const WallRun run = run_wall(wall, 3, [](double) { return 2.0; });
  EXPECT_LE(run.largest_step, 200 * wall.period_s * (1 + 1e-9));
  EXPECT_LT(run.given_J, margin_J);
  EXPECT_LT(run.ripple, 0.2);
}

// ---- drawn axes -----------------------------------------------------------------------------------

SampledWall drawn(std::mt19937& random, double& force) {
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
double softened_J(const SampledWall& wall, double force) {
  const double reach_s = (wall.delay + 1) * wall.period_s;
  return force * force /
         (2 * PassivityController::stiffness_share * wall.plant.inertia / (reach_s * reach_s));
}

TEST(PassivityController, DrawnAxesGiveNoMoreEnergyThanTheSoftenedSpringStores) {
  constexpr int num_axes = 200;
  std::mt19937 random(42);
  int failed_without = 0, over_margin = 0;
  double worst = 0;
  for (int i = 0; i < num_axes; ++i) {
    double force = 0;
    const SampledWall wall = drawn(random, force);
    const double allowed = least_margin_J + softened_J(wall, force);
    const auto push = [force](double) { return force; };
    const WallRun without = run_wall(without_controller(wall), 2.2, push), with = run_wall(wall, 2.2, push);
    failed_without += without.finite && without.given_J <= allowed ? 0 : 1;
    ASSERT_TRUE(with.finite) << i;
    EXPECT_LE(with.given_J, allowed) << i << ": " << wall.plant.inertia << " kg, " << wall.plant.damping
                                     << " N s/m, " << wall.stiffness << " N/m, delay " << wall.delay << ", "
                                     << wall.period_s << " s, count " << wall.count << " m";
    over_margin += with.given_J > margin_J ? 1 : 0;
    worst = std::max(worst, with.given_J);
  }
  std::printf(
      "of %d drawn axes %d give too much without the controller, none with it; with it %d give more "
      "than %g mJ, the worst %.2g mJ\n",
      num_axes, failed_without, over_margin, 1e3 * margin_J, 1e3 * worst);
  EXPECT_GT(failed_without, num_axes / 2);
  EXPECT_LE(over_margin, num_axes / 50);
}

// ---- map ------------------------------------------------------------------------------------------

constexpr std::array grid_N_per_m{200.0, 300.0, 500.0, 700.0, 1e3,  1.5e3, 2e3,  3e3,  5e3,
                                  7e3,   10e3,  15e3,  20e3,  30e3, 50e3,  70e3, 100e3};

/// Returns the stiffest wall of the grid up to which all give no more than the margin, N/m; 0: none does.
double stiffest(SampledWall wall) {
  double last = 0;
  for (const double stiffness : grid_N_per_m) {
    wall.stiffness = stiffness;
    const WallRun run = run_wall(wall, 3, [](double) { return 2.0; });
    if (!run.finite || run.given_J > margin_J) break;
    last = stiffness;
  }
  return last;
}

TEST(ZWidth, TheMapOfTheStiffestPassiveWall) {
  std::printf(
      "stiffest wall of %g kg without a hand, kN/m (grid to %g), and stiffness felt at once with the "
      "controller, N/m\n"
      "| b, N s/m | delay | count, um | rate, kHz | b / (T/2 + t_d) | without | with | at once |\n"
      "|---|---|---|---|---|---|---|---|\n",
      SampledWall{}.plant.inertia, 1e-3 * grid_N_per_m.back());
  const auto row = [](double damping, int delay, double count, double period_s) {
    SampledWall wall;
    wall.plant.damping = damping;
    wall.plant.hand_damping = 0;
    wall.delay = delay;
    wall.count = count;
    wall.period_s = period_s;
    const double reach_s = (delay + 1) * period_s;
    const double soft = PassivityController::stiffness_share * wall.plant.inertia / (reach_s * reach_s);
    const double colgate = damping / (period_s * (0.5 + delay));
    const double without = stiffest(without_controller(wall)), with = stiffest(wall);
    std::printf("| %g | %d | %g | %g | %.2g | %g | %g | %.0f |\n", damping, delay, 1e6 * count,
                1e-3 / period_s, 1e-3 * colgate, 1e-3 * without, 1e-3 * with, soft);
    EXPECT_GE(with, 20e3);
    EXPECT_LE(without, 2 * colgate);
  };
  for (const double damping : {0.1, 0.5, 2.0}) row(damping, 1, 10e-6, 1e-3);
  for (const int delay : {0, 2}) row(0.5, delay, 10e-6, 1e-3);
  for (const double count : {1e-6, 50e-6}) row(0.5, 1, count, 1e-3);
  for (const double period_s : {2.5e-4, 2e-3}) row(0.5, 1, 10e-6, period_s);
}

TEST(ZWidth, LawsOfFrameworksOnTheSameDevice) {
  std::printf("| b, N s/m | delay | rate, kHz | b / (T/2 + t_d) |");
  for (const auto& [name, law] : wall_laws()) std::printf(" %s |", name.c_str());
  std::printf("\n");
  const auto row = [](double damping, int delay, double period_s) {
    SampledWall wall;
    wall.plant.damping = damping;
    wall.plant.hand_damping = 0;
    wall.delay = delay;
    wall.period_s = period_s;
    const double colgate = damping / (period_s * (0.5 + delay));
    std::printf("| %g | %d | %g | %.2g |", damping, delay, 1e-3 / period_s, 1e-3 * colgate);
    std::vector<double> found;
    for (const auto& [name, law] : wall_laws()) {
      wall.law = law;
      found.push_back(stiffest(without_controller(wall)));
      std::printf(" %g |", 1e-3 * found.back());
    }
    std::printf("\n");
    EXPECT_LE(found.front(), 2 * colgate);  // the proxy is the sampled spring
    EXPECT_GE(found.back(), 1.5 * found.front());
  };
  for (const double damping : {0.5, 2.0, 10.0}) row(damping, 1, 1e-3);
  row(2, 0, 1e-3);
  row(2, 1, 2.5e-4);
}

}  // namespace
}  // namespace godobject::test_passivity_controller
