// Passivity of axes that predict their samples, and of axes that move together.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <random>

#include "hal/joint/velocity_estimator.h"
#include "tests/support/drawn_wall.h"

namespace godobject::test_predicted_passivity {
namespace {

// ---- predicted samples ----------------------------------------------------------------------------

/// Returns the law of a spring that is displayed where the device will be after ahead_s, by its estimated
/// velocity.
std::function<double(double)> predicted_law(const SampledWall& wall) {
  return [K = wall.stiffness, ahead_s = wall.ahead_s, period_ns = std::llround(1e9 * wall.period_s),
          estimator = VelocityEstimator(wall.count), t_ns = Nanoseconds{0}](double q) mutable {
    const double x = q + ahead_s * estimator.update(q, t_ns += period_ns);
    return x > 0 ? -K * x : 0;
  };
}

TEST(PredictedPassivity, DrawnAxesThatPredictGiveNoEnergyWithinTheirMargin) {
  constexpr int num_axes = 200;
  std::mt19937 random(7);
  double worst = 0, worst_controlled = 0;
  int failed_undamped = 0;
  for (int i = 0; i < num_axes; ++i) {
    double force = 0;
    SampledWall wall = drawn_wall(random, force);
    wall.law = predicted_law;
    wall.ahead_s = (0.5 + wall.delay) * wall.period_s;
    const double allowed = least_margin_J + softened_J(wall, force);
    const auto push = [force](double) { return force; };
    const WallRun with = run_wall(wall, 2.2, push), without = run_wall(without_controller(wall), 2.2, push);
    failed_undamped += without.finite && without.given_J <= allowed ? 0 : 1;
    EXPECT_TRUE(with.finite) << i;
    EXPECT_LE(with.given_J, allowed) << i << ": " << wall.plant.inertia << " kg, " << wall.plant.damping
                                     << " N s/m, " << wall.stiffness << " N/m, delay " << wall.delay << ", "
                                     << wall.period_s << " s, count " << wall.count << " m";
    worst_controlled = std::max(worst_controlled, with.given_J);
    wall.plant.damping = wall.controller().needed;
    const WallRun within = run_wall(without_controller(wall), 2.2, push);
    EXPECT_TRUE(within.finite && within.given_J <= 1e-9) << i << ": " << within.given_J;
    worst = std::max(worst, within.given_J);
  }
  std::printf(
      "of %d drawn axes that predict %d give too much; with the controller at worst %.2g mJ, within their "
      "margin %.2g mJ\n",
      num_axes, failed_undamped, 1e3 * worst_controlled, 1e3 * worst);
  EXPECT_GT(failed_undamped, num_axes / 8);
}

// ---- axes that move together ----------------------------------------------------------------------

/// Returns the energy that two sliders along one line give, J. Each displays their common wall.
/// needed: of each controller.
double given_by_pair(double needed) {
  constexpr double K = 600, damping = 1, inertia = 0.05, period_s = 1e-3;
  SimPlant plant(
      {.inertia = inertia, .damping = damping, .friction = 0, .hand_stiffness = 0, .hand_damping = 0}, 2,
      true, JointVector::Constant(2, -1e-3), 0);
  std::array<PassivityController, 2> controllers;
  controllers.fill(PassivityController({.inertia = inertia,
                                        .damping = damping,
                                        .needed = needed,
                                        .stiffness = K,
                                        .resolution = 1e-6,
                                        .period_s = period_s}));
  std::array<double, 2> sent{}, acts{};
  double energy = 0, given = 0;
  for (int k = 0; k < 3000; ++k) {
    const JointVector q = plant.q();
    const double depth = std::max(0.0, q(0) + q(1));
    for (std::size_t i = 0; i < 2; ++i) {
      acts[i] = sent[i];
      sent[i] = controllers[i].limit(-K * depth, q(static_cast<Eigen::Index>(i)), true);
      controllers[i].sent(sent[i]);
      plant.set_motor_torque(i, acts[i] + 1);  // pressed by 1 N
    }
    for (int n = 1; n <= 20; ++n) {
      const JointVector before = plant.q();
      plant.advance(k * 1'000'000 + n * SimPlant::substep_ns, JointVector::Zero(2), JointVector::Zero(2));
      for (Eigen::Index i = 0; i < 2; ++i) {
        const double v = plant.q_dot()(i);
        energy += acts[static_cast<std::size_t>(i)] * (plant.q()(i) - before(i)) -
                  damping * v * v * 1e-9 * SimPlant::substep_ns;
      }
    }
    given = std::max(given, energy);
  }
  return given;
}

TEST(CoupledPassivity, AxesThatAreNotPassiveTogetherAreControlledByTheSumOfTheirNeeds) {
  const double alone = 600 * 1.5e-3;  // of 1 N s/m
  EXPECT_GT(given_by_pair(alone), margin_J);
  EXPECT_LT(given_by_pair(2 * alone), margin_J);
}

}  // namespace
}  // namespace godobject::test_predicted_passivity
