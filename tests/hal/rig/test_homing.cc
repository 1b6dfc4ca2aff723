// Homing of a rig with an incremental encoder: the press that sets its zero, and everything that does not.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/supervised_rig.h"

namespace godobject::test_homing {
namespace {

using test::cycles;
using test::ms;
using test::RigTrial;
using test::SupervisedRig;

constexpr double home = 0.5, count = 1e-3;  // rad

void apply(SupervisedRig& world, std::initializer_list<RigTrial> events) {
  for (const RigTrial event : events) world.apply(event);
}

/// A rig that waits for the press, with its joint at rest.
struct World : SupervisedRig {
  explicit World(const RigParams& of_rig = test::params_of_incremental_rig(), std::uint32_t counts = 0)
      : SupervisedRig(of_rig) {
    device.encoder_counts = counts;
    test_homing::apply(*this, {RigTrial::start, RigTrial::wait});
    EXPECT_EQ(rig.state(), RigState::homing) << rig.fault_text();
  }
  DeviceSample sample() { return rig.read(now()); }
};

void press(SupervisedRig& world) {
  apply(world, {RigTrial::press_home, RigTrial::cycle, RigTrial::release_home});
}

TEST(Homing, WaitsWithoutTorqueAndWithoutAPose) {
  World world;
  cycles(world, 1000);
  EXPECT_EQ(world.rig.state(), RigState::homing) << "a person may take longer than boot_timeout";
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  EXPECT_EQ(world.rig.torque_output(), TorqueOutput::none);
  EXPECT_EQ(world.device.drive, cia402::DriveState::switch_on_disabled);
  EXPECT_FALSE(world.sample().valid);
  EXPECT_FALSE(world.rig.arm());
  EXPECT_EQ(world.broken, "");
}

TEST(Homing, APressMakesTheHomePoseRightForAnyCount) {
  std::mt19937 random(1);
  for (int i = 0; i < 30; ++i) {
    World world(test::params_of_incremental_rig(), static_cast<std::uint32_t>(random()));
    press(world);
    const int moved = static_cast<int>(random() % 80) - 40;
    world.device.move(moved);
    cycles(world, 30);
    ASSERT_EQ(world.rig.state(), RigState::ready) << world.rig.fault_text();
    const DeviceSample sample = world.sample();
    EXPECT_TRUE(sample.valid);
    EXPECT_NEAR(sample.q(0), home + moved * count, count / 2);
    ASSERT_TRUE(world.rig.arm());
    cycles(world, 10);
    EXPECT_NE(world.rig.commanded_torque_Nm(0), 0);
  }
}

// The counts wrap after 4096, and the joint turned before the press and after it.
TEST(Homing, TurnsAreCountedFromThePressOn) {
  RigParams params = test::params_of_incremental_rig();
  params.encoders[0].calibration.modulus_counts = 4096;
  params.drives[0].max_slip = 0;
  World world(params, 4000);
  const auto turn = [&world](int num_counts) {
    for (int i = 0; i < num_counts; i += 40) {
      world.device.encoder_counts = (world.device.encoder_counts + 40) % 4096;
      cycles(world, 1);
    }
  };
  turn(10'000);
  world.apply(RigTrial::wait);
  press(world);
  turn(9'000);
  EXPECT_NEAR(world.sample().q(0), home + 9'000 * count, count / 2);
  EXPECT_TRUE(world.sample().valid);
}

TEST(Homing, APressWhileAJointMovesIsRefused) {
  World world;
  for (int i = 0; i < 20; ++i) {
    world.device.move(20);
    cycles(world, 1);
    if (i == 10) press(world);
  }
  EXPECT_EQ(world.rig.state(), RigState::homing);
  EXPECT_EQ(world.rig.refused_presses().count, 1u);
  EXPECT_EQ(world.rig.refused_presses().joint, 0u);
  EXPECT_FALSE(world.sample().valid);
  world.apply(RigTrial::wait);
  EXPECT_EQ(world.rig.state(), RigState::homing) << "a refused press does not act later";
  press(world);
  EXPECT_GT(world.rig.state(), RigState::homing);
  EXPECT_EQ(world.rig.refused_presses().count, 1u);
}

TEST(Homing, RestLastsATenthOfASecond) {
  for (const bool is_long_enough : {false, true}) {
    World world;
    world.device.move(20);
    cycles(world, 1);  // seen here
    cycles(world, is_long_enough ? 99 : 98);
    world.apply(RigTrial::press_home);
    EXPECT_EQ(world.rig.state() > RigState::homing, is_long_enough);
  }
}

// At rest the coordinate may change by 2 counts and 2 mrad: by 4 counts of this encoder.
TEST(Homing, TremorIsRest) {
  for (const int tremor : {3, 5}) {
    World world;
    for (int i = 0; i < 200; ++i) {
      world.device.move(i % 2 == 0 ? tremor : -tremor);
      cycles(world, 1);
    }
    world.apply(RigTrial::press_home);
    EXPECT_EQ(world.rig.refused_presses().count, tremor == 3 ? 0u : 1u);
  }
}

TEST(Homing, AMissingSampleIsNoRest) {
  World world;
  world.device.encoder_answers = false;
  cycles(world, 5);
  world.device.encoder_answers = true;
  cycles(world, 5);
  press(world);
  EXPECT_EQ(world.rig.refused_presses().count, 1u);
  EXPECT_EQ(world.rig.state(), RigState::homing);
}

TEST(Homing, AButtonThatIsPressedAlreadyConfirmsNothing) {
  SupervisedRig world(test::params_of_incremental_rig());
  world.device.home_pressed = true;
  apply(world, {RigTrial::start, RigTrial::wait, RigTrial::wait, RigTrial::wait});
  EXPECT_EQ(world.rig.state(), RigState::homing);
  EXPECT_EQ(world.rig.refused_presses().count, 0u);
  apply(world, {RigTrial::release_home, RigTrial::press_home});
  EXPECT_GT(world.rig.state(), RigState::homing);
}

TEST(Homing, TheStopIsNoConfirmation) {
  World world;
  world.apply(RigTrial::press_stop);
  EXPECT_EQ(world.rig.state(), RigState::fault);
  EXPECT_EQ(world.rig.faults(), RigFault::quick_stop);
}

TEST(Homing, ARestartedEncoderIsHomedAgain) {
  World world;
  press(world);
  apply(world, {RigTrial::wait, RigTrial::arm, RigTrial::cycle, RigTrial::encoder_restarts});
  EXPECT_EQ(world.rig.faults(), RigFault::node_restarted);
  EXPECT_FALSE(world.sample().valid);
  cycles(world, test::ramp_cycles);
  EXPECT_EQ(world.device.torque_per_mille, 0);
  apply(world, {RigTrial::wait, RigTrial::clear, RigTrial::wait, RigTrial::arm});
  EXPECT_EQ(world.rig.state(), RigState::homing) << "never armed with the zero of before";
  EXPECT_FALSE(world.sample().valid);
  press(world);
  world.device.move(-30);
  apply(world, {RigTrial::wait, RigTrial::arm, RigTrial::cycle});
  EXPECT_EQ(world.rig.state(), RigState::armed) << world.rig.fault_text();
  EXPECT_NEAR(world.sample().q(0), home - 30 * count, count / 2);
  EXPECT_EQ(world.broken, "");
}

// Its nodes were up all the time, so the pose stays; but each boot is homed.
TEST(Homing, AFaultOfTheHostKeepsThePoseUntilItIsCleared) {
  World world;
  press(world);
  apply(world, {RigTrial::wait, RigTrial::arm, RigTrial::cycle, RigTrial::deadlines_missed, RigTrial::wait});
  ASSERT_EQ(world.rig.state(), RigState::fault);
  EXPECT_TRUE(world.sample().valid);
  world.apply(RigTrial::clear);
  EXPECT_EQ(world.rig.state(), RigState::homing);
  EXPECT_FALSE(world.sample().valid);
}

TEST(Homing, ALostBusAndALostNodeDropTheZero) {
  for (const auto& [lost, back] : {std::pair(RigTrial::bus_off, RigTrial::bus_on),
                                   std::pair(RigTrial::encoder_unplugged, RigTrial::encoder_plugged)}) {
    World world;
    press(world);
    apply(world,
          {RigTrial::wait, RigTrial::arm, RigTrial::cycle, lost, RigTrial::wait, back, RigTrial::wait});
    ASSERT_EQ(world.rig.state(), RigState::fault);
    EXPECT_FALSE(world.rig.encoder(0).has_zero());
    EXPECT_FALSE(world.sample().valid) << "though its samples are back";
  }
}

// The encoder of the joint is another node.
TEST(Homing, ALostDriveKeepsTheZeroOfTheEncoder) {
  World world;
  press(world);
  apply(world, {RigTrial::wait, RigTrial::arm, RigTrial::cycle, RigTrial::drive_error});
  ASSERT_EQ(world.rig.state(), RigState::fault);
  EXPECT_TRUE(world.rig.encoder(0).has_zero());
}

TEST(Homing, TheWaitIsNoPartOfTheBootsTime) {
  for (const bool is_enabled : {true, false}) {
    RigParams params = test::params_of_incremental_rig();
    params.tree.joints.push_back({.name = "pitch"});
    params.drives.push_back(params.drives[0]);
    params.drives[1].joint = "pitch";
    params.drives[1].node_id = test::idle_drive_id;
    if (is_enabled) params = test::params_of_incremental_rig();
    SupervisedRig world(params);
    world.device.has_idle_drive = !is_enabled;
    apply(world, {RigTrial::start, RigTrial::wait, RigTrial::wait, RigTrial::press_home});
    ASSERT_EQ(world.rig.state(), RigState::enabling);
    cycles(world, 59);
    EXPECT_EQ(world.rig.state(), is_enabled ? RigState::ready : RigState::enabling);
    cycles(world, 2);
    EXPECT_EQ(world.rig.faults(), is_enabled ? RigFault::none : RigFault::boot_timeout);
  }
}

/// The rig whose joint is measured by its drive alone.
RigParams incremental_drive() {
  RigParams params = test::params_of_incremental_rig();
  params.drives[0].calibration = params.encoders[0].calibration;
  params.encoders.clear();
  return params;
}

TEST(Homing, ADriveIsHomedToo) {
  World world(incremental_drive());
  EXPECT_FALSE(world.sample().valid);
  press(world);
  cycles(world, 30);
  ASSERT_EQ(world.rig.state(), RigState::ready) << world.rig.fault_text();
  EXPECT_NEAR(world.sample().q(0), home, count / 2);
}

// A drive without boot-up message could restart within lost_after; once it is enabled its state shows that.
TEST(Homing, ADriveIsNotSilentForLongBeforeItIsEnabled) {
  World world(incremental_drive());
  world.apply(RigTrial::press_home);
  ASSERT_EQ(world.rig.state(), RigState::enabling);
  world.device.drive_answers = false;
  cycles(world, 3 + 3 + 2);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_silent) << world.rig.fault_text();
  EXPECT_FALSE(world.sample().valid);
}

TEST(Homing, NamesThePoseAndTheButton) {
  RigParams params = test::params_of_incremental_rig();
  EXPECT_EQ(
      homing_request(params),
      "put the device into its home pose (yaw 0.5 rad), keep it at rest, then press the button of can0 node "
      "3, input 2");
}

}  // namespace
}  // namespace godobject::test_homing
