#include "sim/rig/plant.h"

#include <gtest/gtest.h>

#include <cmath>

namespace godobject::test_sim_plant {
namespace {

constexpr Nanoseconds ms = 1'000'000;

JointVector one(double x) { return JointVector::Constant(1, x); }

SimPlant one_joint(const PlantConfig& config, double q0 = 0) { return SimPlant(config, 1, true, one(q0), 0); }

PlantConfig frictionless() {
  PlantConfig config;
  config.friction = 0;
  return config;
}

TEST(SimPlant, WithoutHapticsItIsTheReference) {
  SimPlant plant(PlantConfig{}, 2, false, JointVector::Zero(2), 0);
  plant.set_motor_torque(0, 5);
  const JointVector q = JointVector::Constant(2, 0.3), q_dot = JointVector::Constant(2, -1.5);
  plant.advance(ms, q, q_dot);
  EXPECT_EQ(plant.q(), q);
  EXPECT_EQ(plant.q_dot(), q_dot);
}

TEST(SimPlant, ConstantTorqueDeflectsTheHandByTorqueOverStiffness) {
  const PlantConfig config = frictionless();
  SimPlant plant = one_joint(config);
  plant.set_motor_torque(0, 0.4);
  for (int k = 1; k <= 2000; ++k) plant.advance(k * ms, one(0), one(0));
  EXPECT_NEAR(plant.q()(0), 0.4 / config.hand_stiffness, 1e-9);
  EXPECT_NEAR(plant.hand_torque()(0), -0.4, 1e-7);
}

TEST(SimPlant, FrictionHoldsBelowBreakawayAndYieldsAbove) {
  PlantConfig config;
  config.friction = 0.1;
  config.hand_stiffness = 0;
  config.hand_damping = 0;
  SimPlant plant = one_joint(config, 0.2);
  plant.set_motor_torque(0, 0.0999);
  for (int k = 1; k <= 500; ++k) plant.advance(k * ms, one(0), one(0));
  EXPECT_EQ(plant.q()(0), 0.2);
  EXPECT_EQ(plant.q_dot()(0), 0);
  plant.set_motor_torque(0, 0.11);
  for (int k = 501; k <= 3000; ++k) plant.advance(k * ms, one(0), one(0));
  // damping balances the torque beyond friction
  EXPECT_NEAR(plant.q_dot()(0), (0.11 - 0.1) / config.damping, 1e-6);
}

TEST(SimPlant, FollowsAnUndampedOscillationInClosedForm) {
  PlantConfig config = frictionless();
  config.damping = 0;
  config.hand_damping = 0;
  config.inertia = 0.1;
  config.hand_stiffness = 10;  // omega = 10 rad/s
  SimPlant plant = one_joint(config, 0.01);
  for (int k = 1; k <= 300; ++k) plant.advance(k * ms, one(0), one(0));
  EXPECT_NEAR(plant.q()(0), 0.01 * std::cos(3.0), 1e-4);  // first order: h omega^2 t / 2 = 0.8 % of it
}

TEST(SimPlant, TracksAMovingReferenceWithoutLagInSteadyMotion) {
  PlantConfig config = frictionless();
  config.damping = 0;
  SimPlant plant = one_joint(config);
  for (int k = 1; k <= 2000; ++k) plant.advance(k * ms, one(0.5e-3 * k), one(0.5));
  EXPECT_NEAR(plant.q()(0), 1.0, 1e-9);
  EXPECT_NEAR(plant.q_dot()(0), 0.5, 1e-9);
}

// Work of motor and hand >= change of kinetic energy: damping and friction only dissipate.
TEST(SimPlant, PassiveOverAnyMotionOfHandAndMotor) {
  PlantConfig config;
  config.friction = 0.02;
  SimPlant plant = one_joint(config);
  double work = 0, dissipated_least = 0;
  constexpr double h = 1e-9 * static_cast<double>(SimPlant::substep_ns);
  for (int k = 1; k <= 20000; ++k) {
    const double t = h * k, torque = 0.3 * std::sin(40 * t);
    plant.set_motor_torque(0, torque);
    plant.advance(k * SimPlant::substep_ns, one(0.2 * std::sin(7 * t)), one(1.4 * std::cos(7 * t)));
    const double v = plant.q_dot()(0);
    work += h * v * (torque + plant.hand_torque()(0));
    dissipated_least += h * (config.damping * v * v + config.friction * std::abs(v));
    const double kinetic = 0.5 * config.inertia * v * v;
    ASSERT_GE(work, kinetic + dissipated_least - 1e-12) << k;
  }
  EXPECT_GT(dissipated_least, 1e-3);
}

TEST(SimPlant, StableForExtremeParameters) {
  for (const double inertia : {1e-9, 1e-3, 10.0}) {
    for (const double stiffness : {0.0, 20.0, 1e9}) {
      for (const double damping : {0.0, 1.0, 1e6}) {
        PlantConfig config;
        config.inertia = inertia;
        config.hand_stiffness = stiffness;
        config.hand_damping = damping;
        SimPlant plant = one_joint(config, 0.1);
        for (int k = 1; k <= 200; ++k) {
          plant.advance(k * ms, one(0), one(0));
          ASSERT_LE(std::abs(plant.q()(0)), 0.1 * (1 + 1e-12));
        }
      }
    }
  }
}

TEST(SimPlant, SubstepsDoNotDependOnHowTheTimeIsCutUp) {
  SimPlant coarse = one_joint(PlantConfig{}, 0.1), fine = one_joint(PlantConfig{}, 0.1);
  for (int k = 1; k <= 10; ++k) coarse.advance(k * ms, one(0), one(0));
  for (int k = 1; k <= 1000; ++k) fine.advance(k * ms / 100, one(0), one(0));
  EXPECT_EQ(coarse.q(), fine.q());
  EXPECT_EQ(coarse.q_dot(), fine.q_dot());
}

}  // namespace
}  // namespace godobject::test_sim_plant
