// Bounds of the supervision, at their last cycle before and their first cycle after.
#include <gtest/gtest.h>

#include "tests/support/supervised_rig.h"

namespace godobject::test_supervise {
namespace {

using test::ms;
using test::RigTrial;
using test::SupervisedRig;

void cycles(SupervisedRig& world, int count) {
  for (int i = 0; i < count; ++i) world.apply(RigTrial::cycle);
}

void boot_and_arm(SupervisedRig& world) {
  for (const RigTrial event : {RigTrial::start, RigTrial::wait, RigTrial::arm}) world.apply(event);
  ASSERT_EQ(world.rig.state(), RigState::armed) << world.rig.fault_text();
}

TEST(Supervise, StartsANodeAgainAfter250Ms) {
  RigParams params = test::params_of_rig();
  params.boot_timeout_s = 1;
  SupervisedRig world(params);
  world.device.encoder_stays_down = true;
  world.apply(RigTrial::start);
  ASSERT_EQ(world.device.nmt_starts_of_encoder, 1);
  cycles(world, 249);
  EXPECT_EQ(world.device.nmt_starts_of_encoder, 1);
  cycles(world, 1);
  EXPECT_EQ(world.device.nmt_starts_of_encoder, 2);
}

// A joint in motion may be sampled stale_after later than its motor.
TEST(Supervise, TravelOfTheFasterSensorIsNoSlip) {
  SupervisedRig world;
  boot_and_arm(world);
  for (const int direction : {1, -1, 1, -1})
    for (int i = 0; i < 4; ++i) {
      world.device.encoder_counts += static_cast<std::uint32_t>(direction * 30);  // 30 rad/s
      cycles(world, 1);
      ASSERT_EQ(world.rig.faults(), RigFault::none) << world.rig.fault_text();
    }
}

/// Runs until the drive is enabled, before ready.
void boot_to_enabled_drive(SupervisedRig& world) {
  world.apply(RigTrial::start);
  while (world.rig.drive_feedback(0, world.now()).state != MotorState::enabled) cycles(world, 1);
  ASSERT_EQ(world.rig.state(), RigState::enabling);
}

int cycles_to_fault(SupervisedRig& world) {
  int count = 0;
  for (; count < 1000 && world.rig.state() != RigState::fault; ++count) cycles(world, 1);
  return count;
}

TEST(Supervise, FailureWhileEnablingIsRaisedWithItsCode) {
  SupervisedRig world;
  boot_to_enabled_drive(world);
  world.device.drive = cia402::DriveState::fault;
  cycles(world, 1);
  EXPECT_EQ(world.rig.state(), RigState::enabling) << "the code may come later";
  world.device.send(cia402::make_event(test::drive_id, {.mode = 10, .error_code = 0x2310}), world.now());
  cycles(world, 1);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_error);
  EXPECT_EQ(world.rig.fault_log().first(RigFault::drive_error).place.drive_code, 0x2310u);
}

TEST(Supervise, CodeFromBeforeTheFailureIsNotItsCode) {
  SupervisedRig world;
  boot_to_enabled_drive(world);
  world.device.send(cia402::make_event(test::drive_id, {.mode = 10, .error_code = 0x1000}), world.now());
  cycles(world, 1);
  world.device.drive = cia402::DriveState::switch_on_disabled;
  EXPECT_EQ(cycles_to_fault(world), 1 + 8 + 1);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_not_enabled);
}

TEST(Supervise, FailureWithoutACodeIsRaisedAfterLostAfter) {
  for (const cia402::DriveState failed :
       {cia402::DriveState::fault, cia402::DriveState::switch_on_disabled}) {
    SupervisedRig world;
    boot_to_enabled_drive(world);
    world.device.drive = failed;
    EXPECT_EQ(cycles_to_fault(world), 1 + 8 + 1);  // in its first cycle, and lost_after exceeded
    const bool is_fault = failed == cia402::DriveState::fault;
    EXPECT_EQ(world.rig.faults(), is_fault ? RigFault::drive_error : RigFault::drive_not_enabled);
  }
}

// Late answers look fresh; the time without a pose counts from the first mark that has shown the delay.
TEST(Supervise, DelayBeyondReachIsASampleLost) {
  SupervisedRig world;
  boot_and_arm(world);
  world.device.delay_cycles = 5;
  EXPECT_LE(cycles_to_fault(world), 5 + 2 * 8 + 8 * 3 + 50);
  EXPECT_TRUE(any(world.rig.faults() & RigFault::sample_stale)) << world.rig.fault_text();
}

TEST(Supervise, DelayBeyondReachFromTheStartNeverBoots) {
  RigParams params = test::params_of_rig();
  params.boot_timeout_s = 0.5;
  SupervisedRig world(params);
  world.device.delay_cycles = 5;
  world.apply(RigTrial::start);
  EXPECT_EQ(cycles_to_fault(world), 500);
  EXPECT_EQ(world.rig.faults(), RigFault::boot_timeout);
}

// The slack of a hinge is 0.05 rad and two counts of each sensor: 54 counts.
TEST(Supervise, SensorsDisagreeBeyondTheSlackOfTheJoint) {
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

TEST(Supervise, SensorsMayDisagreeForStaleAfter) {
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

TEST(Supervise, BootTimeoutNamesTheNodeWithoutASample) {
  for (const bool is_drive : {false, true}) {
    SupervisedRig world;
    (is_drive ? world.device.drive_answers : world.device.encoder_answers) = false;
    world.apply(RigTrial::start);
    EXPECT_EQ(cycles_to_fault(world), 60);
    ASSERT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
    const RigFaultPlace& place = world.rig.fault_log().records()[0].place;
    EXPECT_EQ(place.fault, RigFault::boot_timeout);
    EXPECT_EQ(place.node_id, is_drive ? test::drive_id : test::encoder_id);
  }
}

TEST(Supervise, FaultHasTheTimeOfItsCycle) {
  SupervisedRig world;
  boot_and_arm(world);
  const Nanoseconds later = world.now() + 50 * ms;
  static_cast<void>(world.rig.read(later));
  EXPECT_EQ(world.rig.fault_log().first(RigFault::heartbeat_lost).t_ns, later);
}

TEST(Supervise, SlipOfZeroIsNotCompared) {
  RigParams params = test::params_of_rig();
  params.drives[0].max_slip = 0;
  SupervisedRig world(params);
  boot_and_arm(world);
  world.device.drive_counts = 50;
  cycles(world, 100);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

TEST(Supervise, HeartbeatIsLostAfterItsTimeout) {
  SupervisedRig world;
  boot_and_arm(world);
  cycles(world, 1000 - static_cast<int>(world.now() / ms % 10));  // the last heartbeats were 10 cycles ago
  world.device.sends_heartbeats = false;
  EXPECT_EQ(cycles_to_fault(world), 30 - 10 + 2);  // not in the cycle in which 30 ms have passed
  EXPECT_EQ(world.rig.faults(), RigFault::heartbeat_lost);
}

// The last answers are 2.5 ms old when the heartbeats come: the next cycle has none that is fresh.
TEST(Supervise, TimeWithoutASampleCountsFromTheBoot) {
  SupervisedRig world;
  world.device.sends_heartbeats = false;
  world.apply(RigTrial::start);
  while (world.now() < 29 * ms) cycles(world, 1);
  world.device.answers_sync = false;
  cycles(world, 1);
  world.device.sends_heartbeats = true;
  cycles(world, 1);
  ASSERT_EQ(world.rig.state(), RigState::enabling);
  EXPECT_EQ(cycles_to_fault(world), 8 + 1);
  EXPECT_EQ(world.rig.faults(), RigFault::sample_stale | RigFault::drive_silent);
}

// The older position of a drive that answers every 8th SYNC is compared with the joint's at that time.
TEST(Supervise, SensorsThatMoveTogetherAgree) {
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
}  // namespace godobject::test_supervise
