// The passivity controller in the rig: a wall on a slider with one drive, through wires and counts.
#include <gtest/gtest.h>

#include <array>

#include "platform/session/passivity.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test::test_rig_passivity {
namespace {

constexpr double mass = 0.05, damping = 0.5, stiffness = 20e3;  // kg, N s/m, N/m
constexpr double motor_radius = 0.01;                           // m/rad

RigParams slider_params() {
  RigParams rig = slider_rig_params(motor_radius, 1e5);  // 10 um
  DriveParams& drive = rig.drives.front();
  drive.sign = -1;
  drive.torque_rated_Nm = 0.1;
  drive.torque_max_Nm = 0.3;
  drive.torque_rate_Nm_per_s = 100;
  return rig;
}

/// Controllers of the drives, for any protocol and period of the slider.
std::vector<PassivityParams> controllers(double energy_J) {
  const SampledAxis axis{.inertia = mass, .damping = damping, .K = stiffness};
  return {{.inertia = mass,
           .damping = damping,
           .needed = axis.needed(),
           .stiffness = stiffness,
           .resolution = 1e-5,
           .energy_J = energy_J}};
}

class RigPassivity : public testing::Test {
 protected:
  RigPassivity()
      : rig(slider_params(), true,
            PlantConfig{{.inertia = mass,
                         .damping = damping,
                         .friction = 0,
                         .hand_stiffness = 500,
                         .hand_damping = 5}}) {
    rig.q_ref = [this](double) { return JointVector::Constant(1, hand); };
  }

  void arm(double energy_J) {
    rig.rig->control_passivity(controllers(energy_J));
    ASSERT_TRUE(rig.boot()) << rig.rig->fault_text();
    ASSERT_TRUE(rig.rig->arm());
  }

  /// One cycle with the wall at q = 0. Returns the force at the slider that the drive applies, N.
  double cycle() {
    rig.begin_cycle();
    const double q = rig.sample.q(0);
    const std::array F{Wrench{.f = Vec3(q > 0 ? -stiffness * q : 0, 0, 0)}};
    rig.end_cycle(F);
    return rig.applied_joint_torque(0);
  }

  /// Presses with the hand from a millimetre before the wall. Returns the force's peak to peak in the last
  /// quarter of a second.
  double press(double force_N) {
    double low = 1e9, high = -1e9;
    for (int k = 0; k < 2000; ++k) {
      hand = -1e-3 + std::min(1.0, k / 1000.0) * (1e-3 + force_N / 500);
      const double force = cycle();
      if (k < 1750) continue;
      low = std::min(low, force);
      high = std::max(high, force);
    }
    return high - low;
  }

  SimulatedRig rig;
  double hand = -1e-3;  // place of the hand, m
};

TEST_F(RigPassivity, AWallBuzzesWithoutTheController) {
  arm(0);
  EXPECT_GT(press(5), 5);
  EXPECT_EQ(rig.rig->generated_energy_J(0), 0);
}

TEST_F(RigPassivity, AWallIsQuietWithIt) {
  arm(PassivityParams{}.energy_J);
  const double per_mille = 1e-3 * 0.1 / motor_radius;  // N, rounding of a command
  EXPECT_LT(press(5), 0.1 + 2 * per_mille);
  EXPECT_NEAR(rig.applied_joint_torque(0), -stiffness * rig.plant.q()(0), 0.02 * 5 + 0.1);
  EXPECT_GE(rig.rig->generated_energy_J(0), 0);
  EXPECT_EQ(rig.rig->faults(), RigFault::none) << rig.rig->fault_text();
}

TEST_F(RigPassivity, AFaultRunsTheTorqueDownAndForgetsTheEnergy) {
  arm(PassivityParams{}.energy_J);
  // a wall in which the device starts
  hand = 1e-3;
  for (int k = 0; k < 50; ++k) cycle();
  EXPECT_GT(rig.rig->generated_energy_J(0), 0);
  rig.rig->quick_stop();
  for (int k = 0; k < 10; ++k) cycle();
  EXPECT_EQ(rig.rig->commanded_torque_Nm(0), 0);
  EXPECT_EQ(rig.rig->generated_energy_J(0), 0);
}

TEST_F(RigPassivity, TheRateOfTheDriveIsKeptAtReArming) {
  arm(PassivityParams{}.energy_J);
  hand = 1e-3;
  for (int k = 0; k < 200; ++k) cycle();
  double last = rig.rig->commanded_torque_Nm(0);
  const double most = slider_params().drives[0].torque_rate_Nm_per_s * SimulatedRig::cycle_s * (1 + 1e-9);
  const auto step = [&] {
    cycle();
    EXPECT_LE(std::abs(rig.rig->commanded_torque_Nm(0) - last), most);
    last = rig.rig->commanded_torque_Nm(0);
  };
  rig.rig->disarm();
  for (int k = 0; k < 20; ++k) step();
  EXPECT_EQ(last, 0);
  EXPECT_EQ(rig.rig->generated_energy_J(0), 0);
  ASSERT_TRUE(rig.rig->arm());
  for (int k = 0; k < 200; ++k) step();
  EXPECT_NE(last, 0);
}

TEST_F(RigPassivity, CyclesWithTheControllerDoNotAllocate) {
  arm(PassivityParams{}.energy_J);
  hand = 1e-3;
  cycle();
  AllocationGuard guard;
  for (int k = 0; k < 200; ++k) cycle();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

TEST_F(RigPassivity, ALostSampleIsNoMotion) {
  arm(PassivityParams{}.energy_J);
  rig.drive_ports[0]->set_loss_probability(0.2);
  EXPECT_LT(press(5), 1);
}

}  // namespace
}  // namespace godobject::test::test_rig_passivity
