// Bounds of the supervision, at their last cycle before and their first cycle after.
#include <gtest/gtest.h>

#include "tests/support/supervised_rig.h"

namespace godobject::test_supervise {
namespace {

using test::boot_and_arm;
using test::cycles;
using test::ms;
using test::RigTrial;
using test::SupervisedRig;

TEST(Supervise, StartsANodeAgainEvery250Ms) {
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
  cycles(world, 249);
  EXPECT_EQ(world.device.nmt_starts_of_encoder, 2);
  cycles(world, 1);
  EXPECT_EQ(world.device.nmt_starts_of_encoder, 3);
}

TEST(Supervise, StartsNoNodeThatIsOperational) {
  SupervisedRig world;
  world.device.encoder_nmt = canopen::NmtState::operational;
  world.apply(RigTrial::start);
  world.apply(RigTrial::wait);
  EXPECT_EQ(world.rig.state(), RigState::ready) << world.rig.fault_text();
  EXPECT_EQ(world.device.nmt_starts_of_encoder, 0);
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

TEST(Supervise, EndOfAnOldCodeIsNoCode) {
  SupervisedRig world;
  boot_to_enabled_drive(world);
  world.device.send(cia402::make_event(test::drive_id, {.mode = 10, .error_code = 0x1000}), world.now());
  cycles(world, 1);
  world.device.drive = cia402::DriveState::fault;
  world.device.send(cia402::make_event(test::drive_id, {.mode = 10}), world.now());
  EXPECT_EQ(cycles_to_fault(world), 1 + 8 + 1);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_error);
}

// The boot's time is over while the code of a failure is awaited.
TEST(Supervise, FailureIsNoBootTimeout) {
  SupervisedRig world;
  world.device.sends_heartbeats = false;
  world.apply(RigTrial::start);
  while (world.now() < 40 * ms) cycles(world, 1);
  world.device.sends_heartbeats = true;
  while (world.rig.drive_feedback(0, world.now()).state != MotorState::enabled) cycles(world, 1);
  while (world.now() < 52 * ms) cycles(world, 1);
  ASSERT_EQ(world.rig.state(), RigState::enabling);
  world.device.drive = cia402::DriveState::switch_on_disabled;
  static_cast<void>(cycles_to_fault(world));
  EXPECT_GT(world.now(), 60 * ms);
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
    world.apply(RigTrial::clear);
    world.apply(RigTrial::wait);
    EXPECT_EQ(world.rig.state(), RigState::ready) << "enabled again after clearing";
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

TEST(Supervise, BootTimeoutNamesTheDriveThatIsNotEnabled) {
  RigParams params = test::params_of_rig();
  params.tree.joints.push_back({.name = "pitch"});
  params.drives.push_back(params.drives[0]);
  params.drives[1].joint = "pitch";
  params.drives[1].node_id = test::idle_drive_id;
  SupervisedRig world(params);
  world.device.has_idle_drive = true;
  world.apply(RigTrial::start);
  EXPECT_EQ(cycles_to_fault(world), 60);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
  EXPECT_EQ(world.rig.faults(), RigFault::boot_timeout);
  EXPECT_EQ(world.rig.fault_log().records()[0].place.node_id, test::idle_drive_id);
}

// The drive is still enabled, so only the ten cycles before drives_up pass.
TEST(Supervise, WaitsForTheDrivesAfterEachBoot) {
  SupervisedRig world;
  boot_and_arm(world);
  world.apply(RigTrial::deadlines_missed);
  world.apply(RigTrial::clear);
  int count = 1;
  for (; count < 100 && world.rig.state() != RigState::ready; ++count) cycles(world, 1);
  EXPECT_EQ(count, 10 + 1);
}

TEST(Supervise, FaultHasTheTimeOfItsCycle) {
  SupervisedRig world;
  boot_and_arm(world);
  const Nanoseconds later = world.now() + 50 * ms;
  static_cast<void>(world.rig.read(later));
  EXPECT_EQ(world.rig.fault_log().first(RigFault::heartbeat_lost).t_ns, later);
}

// The drive answers, but none of its positions is plausible: there is no sample.
TEST(Supervise, ImplausiblePositionsOfADriveAreNoSamples) {
  RigParams params = test::params_of_rig();
  params.encoders.clear();
  SupervisedRig world(params);
  boot_and_arm(world);
  for (int i = 0; i < 3 + 8 + 3; ++i) {
    world.device.drive_counts += i % 2 == 0 ? 1000 : 3000;
    cycles(world, 1);
  }
  EXPECT_EQ(world.rig.faults(), RigFault::sample_implausible | RigFault::sample_stale);
}

TEST(Supervise, DelayOfALogIsNotMeasured) {
  SupervisedRig world;
  world.device.live = false;
  boot_and_arm(world);
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

TEST(Supervise, EachBusIsSupervised) {
  RigParams params = test::params_of_rig();
  params.buses.push_back({.name = "can1"});
  params.buttons[0].bus = 1;
  for (const std::size_t off : {0u, 1u}) {
    std::array<test::ScriptedDevice, 2> devices;
    const std::array<CanBus*, 2> buses{&devices[0], &devices[1]};
    Rig rig(params, test::cycle_s, buses);
    rig.start(0);
    devices[off].is_off = true;
    static_cast<void>(rig.read(0));
    EXPECT_EQ(rig.faults(), RigFault::bus_down);
    ASSERT_EQ(rig.fault_log().records().size(), 1u);
    EXPECT_EQ(rig.fault_log().records()[0].place.bus, off);
  }
}

TEST(Supervise, BootMayTakeItsWholeTimeout) {
  RigParams params = test::params_of_rig();
  params.boot_timeout_s = 0.5;
  SupervisedRig world(params);
  world.rig.start(0);
  static_cast<void>(world.rig.read(500 * ms));
  EXPECT_EQ(world.rig.state(), RigState::booting);
  static_cast<void>(world.rig.read(500 * ms + 1));
  EXPECT_EQ(world.rig.faults(), RigFault::boot_timeout);
}

TEST(Supervise, DrivesDisabledByAQuickStopAreNoFurtherFault) {
  SupervisedRig world;
  boot_and_arm(world);
  world.apply(RigTrial::quick_stop);
  cycles(world, 10);
  EXPECT_NE(world.device.drive, cia402::DriveState::operation_enabled);
  EXPECT_EQ(world.rig.faults(), RigFault::quick_stop) << world.rig.fault_text();
}

// The joint has an encoder, so the drive's position is no sample that could be missing.
TEST(Supervise, SilentDriveBesideAnEncoderIsOneFault) {
  SupervisedRig world;
  boot_and_arm(world);
  world.device.drive_answers = false;
  EXPECT_EQ(cycles_to_fault(world), 3 + 8);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_silent) << world.rig.fault_text();
  cycles(world, 10);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_silent) << world.rig.fault_text();
  EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0);
}

}  // namespace
}  // namespace godobject::test_supervise
