// The passivity controller on a simulated axis that renders a wall.
#include "hal/rig/passivity_controller.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "tests/support/drawn_wall.h"

namespace godobject::test_passivity_controller {
namespace {

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

TEST(PassivityController, DrawnAxesGiveNoMoreEnergyThanTheSoftenedSpringStores) {
  constexpr int num_axes = 200;
  std::mt19937 random(42);
  int failed_without = 0, over_margin = 0;
  double worst = 0;
  for (int i = 0; i < num_axes; ++i) {
    double force = 0;
    const SampledWall wall = drawn_wall(random, force);
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

}  // namespace
}  // namespace godobject::test_passivity_controller
