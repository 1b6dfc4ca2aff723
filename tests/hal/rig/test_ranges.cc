// Joints beyond the range that their device states.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/support/supervised_rig.h"

namespace godobject::test_ranges {
namespace {

using test::boot_and_arm;
using test::cycles;
using test::RigTrial;
using test::SupervisedRig;

/// Returns a rig whose joint turns from -0.2 to 0.8 rad: a tenth beyond are -300 and 900 counts.
RigParams params_with_range() {
  RigParams params = test::params_of_rig();
  params.tree.joints[0].lower = -0.2;
  params.tree.joints[0].upper = 0.8;
  return params;
}

void turn_to(SupervisedRig& world, int counts) {
  for (int at = 0; at != counts;) {
    const int step = std::clamp(counts - at, -10, 10);  // at most 10 rad/s
    at += step;
    world.device.encoder_counts += static_cast<std::uint32_t>(step);
    world.device.drive_counts += step;
    cycles(world, 1);
  }
}

TEST(Ranges, AJointMayBeATenthOfItsRangeBeyondEachEnd) {
  for (const auto& [counts, is_beyond] : {std::pair{-300, false}, {-301, true}, {900, false}, {901, true}}) {
    SupervisedRig world(params_with_range());
    boot_and_arm(world);
    turn_to(world, counts);
    cycles(world, 20);
    EXPECT_EQ(world.rig.faults(), is_beyond ? RigFault::joint_beyond_range : RigFault::none) << counts;
    EXPECT_EQ(world.device.torque_per_mille == 0, is_beyond) << counts;
    EXPECT_EQ(world.broken, "");
  }
}

TEST(Ranges, TheFaultNamesTheSensorOfTheJoint) {
  SupervisedRig world(params_with_range());
  boot_and_arm(world);
  turn_to(world, 950);
  const RigFaultPlace place = world.rig.fault_log().first(RigFault::joint_beyond_range).place;
  EXPECT_EQ(place.node_id, test::encoder_id);
  RigParams params = params_with_range();
  params.encoders.clear();
  params.drives[0].max_slip = 0;
  SupervisedRig measured_by_drive(params);
  boot_and_arm(measured_by_drive);
  turn_to(measured_by_drive, 950);
  EXPECT_EQ(measured_by_drive.rig.fault_log().first(RigFault::joint_beyond_range).place.node_id,
            test::drive_id);
}

// stale_after is 3 ms.
TEST(Ranges, ABlowAgainstAnEndIsNoFault) {
  for (const auto& [num_cycles, fault] : {std::pair{3, RigFault::none}, {4, RigFault::joint_beyond_range}}) {
    SupervisedRig world(params_with_range());
    boot_and_arm(world);
    turn_to(world, 900);
    world.device.move(1);
    cycles(world, num_cycles);
    world.device.move(-1);
    cycles(world, 20);
    EXPECT_EQ(world.rig.faults(), fault) << num_cycles;
  }
}

TEST(Ranges, AWrongZeroIsFoundBeforeTheFirstTorqueAndAgainAfterEachClear) {
  SupervisedRig world(params_with_range());
  world.device.encoder_counts = static_cast<std::uint32_t>(-1000);
  world.apply(RigTrial::start);
  for (int boot = 0; boot < 3; ++boot) {
    for (int i = 0; i < test::longest_timeout_cycles; ++i) {
      cycles(world, 1);
      ASSERT_FALSE(world.rig.ready());
    }
    EXPECT_EQ(world.rig.faults(), RigFault::joint_beyond_range);
    world.apply(RigTrial::clear);
  }
  EXPECT_TRUE(any(never_rearmed & RigFault::joint_beyond_range));
}

TEST(Ranges, ACoordinateWithoutAZeroIsNotCompared) {
  RigParams params = test::params_of_incremental_rig();
  params.tree.joints[0].lower = 0.4;
  params.tree.joints[0].upper = 0.6;
  SupervisedRig world(params);
  world.device.encoder_counts = 5000;
  for (const RigTrial event : {RigTrial::start, RigTrial::wait}) world.apply(event);
  EXPECT_EQ(world.rig.state(), RigState::homing);
  world.apply(RigTrial::press_home);
  for (const RigTrial event : {RigTrial::wait, RigTrial::arm}) world.apply(event);
  ASSERT_EQ(world.rig.state(), RigState::armed) << world.rig.fault_text();
  for (int i = 0; i < 12; ++i) {
    world.device.move(20);
    cycles(world, 1);
  }
  EXPECT_EQ(world.rig.faults(), RigFault::joint_beyond_range);
  EXPECT_FALSE(world.rig.encoder(0).has_zero());
}

// The joint turns by half the angle of its actuator. The joint has the range.
TEST(Ranges, AreThoseOfJointsBeyondATransmission) {
  RigParams params = params_with_range();
  params.transmissions = {{.joints = {"yaw"}, .joint_per_actuator = {{0.5}}}};
  for (const auto& [counts, is_beyond] : {std::pair{1800, false}, {1802, true}}) {
    SupervisedRig world(params);
    boot_and_arm(world);
    turn_to(world, counts);
    cycles(world, 20);
    EXPECT_EQ(any(world.rig.faults()), is_beyond) << counts;
  }
}

TEST(Ranges, AJointWithoutARangeHasNoBounds) {
  SupervisedRig world;
  boot_and_arm(world);
  turn_to(world, 3000);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

}  // namespace
}  // namespace godobject::test_ranges
