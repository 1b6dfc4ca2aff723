// Comparison of a drive's position with its joint's encoder.
#include <gtest/gtest.h>

#include "tests/support/supervised_rig.h"

namespace godobject::test_slip {
namespace {

using test::boot_and_arm;
using test::cycles;
using test::ms;
using test::RigTrial;
using test::SupervisedRig;

// A joint in motion may be sampled stale_after later than its motor.
TEST(Slip, TravelOfTheFasterSensorIsNoSlip) {
  SupervisedRig world;
  boot_and_arm(world);
  for (const int direction : {1, -1, 1, -1})
    for (int i = 0; i < 4; ++i) {
      world.device.encoder_counts += static_cast<std::uint32_t>(direction * 30);  // 30 rad/s
      cycles(world, 1);
      ASSERT_EQ(world.rig.faults(), RigFault::none) << world.rig.fault_text();
    }
}

// The slack of a hinge is 0.05 rad and two counts of each sensor: 54 counts.
TEST(Slip, SensorsDisagreeBeyondTheSlackOfTheJoint) {
  for (const int apart : {54, 55}) {
    SupervisedRig world;
    boot_and_arm(world);
    for (int moved = 0; moved < apart; ++moved) {  // 1 rad/s: a travel of 3 counts
      ++world.device.drive_counts;
      cycles(world, 1);
    }
    ASSERT_EQ(world.rig.faults(), RigFault::none);
    cycles(world, 100);
    EXPECT_EQ(world.rig.faults(), apart == 54 ? RigFault::none : RigFault::sensors_disagree);
  }
}

TEST(Slip, SensorsMayDisagreeForStaleAfter) {
  SupervisedRig world;
  boot_and_arm(world);
  for (int moved = 0; moved < 58; ++moved) {
    ++world.device.drive_counts;
    cycles(world, 1);
  }
  world.device.drive_counts -= 20;
  cycles(world, 100);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

TEST(Slip, SensorsThatPartInMotionDisagree) {
  SupervisedRig world;
  boot_and_arm(world);
  int count = 0;
  for (; count < 50 && world.rig.state() != RigState::fault; ++count) {
    world.device.drive_counts += 10;  // 10 rad/s: a travel of 30 counts
    cycles(world, 1);
  }
  EXPECT_EQ(count, 9 + 3);  // 90 counts are beyond 84, for more than stale_after in the fourth cycle
  EXPECT_EQ(world.rig.faults(), RigFault::sensors_disagree);
}

TEST(Slip, ZeroOfADriveIsThatOfItsPowerOn) {
  SupervisedRig world;
  world.device.drive_counts = 500;
  boot_and_arm(world);
  cycles(world, 100);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

TEST(Slip, MissingSampleIsNotCompared) {
  SupervisedRig world;
  boot_and_arm(world);
  world.device.encoder_answers = false;
  for (int i = 0; i < 50; ++i) {
    world.device.drive_counts += 10;
    cycles(world, 1);
  }
  EXPECT_EQ(world.rig.faults(), RigFault::sample_stale);
}

TEST(Slip, SlipOfZeroIsNotCompared) {
  RigParams params = test::params_of_rig();
  params.drives[0].max_slip = 0;
  SupervisedRig world(params);
  boot_and_arm(world);
  world.device.drive_counts = 50;
  cycles(world, 100);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

// The older position of a drive that answers every 8th SYNC is compared with the joint's at that time.
TEST(Slip, SensorsThatMoveTogetherAgree) {
  for (const std::uint8_t every_nth : {std::uint8_t{1}, std::uint8_t{8}}) {
    RigParams params = test::params_of_rig();
    params.drives[0].status_every_nth_sync = every_nth;
    params.boot_timeout_s = 1;
    SupervisedRig world(params);
    world.device.status_every_nth_sync = every_nth;
    world.apply(RigTrial::start);
    for (int i = 0; i < 900 && world.rig.state() != RigState::ready; ++i) cycles(world, 1);
    world.apply(RigTrial::arm);
    ASSERT_EQ(world.rig.state(), RigState::armed) << world.rig.fault_text();
    for (int i = 0; i < 100; ++i) {
      world.device.encoder_counts += 30;
      world.device.drive_counts += 30;
      cycles(world, 1);
      ASSERT_EQ(world.rig.faults(), RigFault::none) << world.rig.fault_text();
    }
  }
}

}  // namespace
}  // namespace godobject::test_slip
