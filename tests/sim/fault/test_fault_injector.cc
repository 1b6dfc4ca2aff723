// Start and end of faults; test_fault_promise.cc tests the reaction of a rig to each.
#include "sim/fault/injector.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/allocation_guard.h"
#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_fault_injector {
namespace {

TEST(FaultInjector, SpikeWithoutDurationIsOneSample) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot());
  const std::uint64_t before = device.rig.encoder(0).counters().implausible;
  device.play("spike bus=can0 node=1 value=0.5");
  device.cycles(20);
  EXPECT_EQ(device.rig.encoder(0).counters().implausible, before + 1);
}

TEST(FaultInjector, LateCopiesOfAnAnswerAreNoNewSamples) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot());
  device.play("delay bus=can0 value=8e-4");
  device.play("duplicate bus=can0 node=1");
  EXPECT_FALSE(device.cycles_to_fault(500)) << device.rig.fault_text();
}

TEST(FaultInjector, NodesThatCorruptFramesHaveMadeBusOffComeBackWhenItEnds) {
  for (const char* const where : {"bus=can0 node=1", "bus=can1 node=2", "bus=can0", "bus=can1", ""})
    for (const char* const share : {"0.5", "0.8", "1"}) {
      test::FaultyRig device;
      ASSERT_TRUE(device.boot());
      device.play(std::string("corrupt ") + where + " value=" + share + " duration=0.3");
      EXPECT_TRUE(device.cycles_to_fault(500)) << where << ' ' << share;
      device.cycles(400);
      EXPECT_TRUE(device.link.rig().faults().active().empty());
      for (const std::size_t bus : {0u, 1u})
        for (const std::uint8_t id : std::initializer_list<std::uint8_t>{1, 2})
          EXPECT_NE(device.link.rig().node_port(bus, id)->state(), BusState::bus_off)
              << where << ' ' << share;
      device.rig.clear_faults(device.t_sync_ns);
      EXPECT_TRUE(device.boot()) << where << ' ' << share << ": " << device.rig.fault_text();
    }
}

TEST(FaultInjector, StuckSensorShowsWhereItWas) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot());
  device.play("stuck bus=can0 node=1 duration=0.1");
  device.cycles(2);
  const double q = device.sample.q[0];
  device.cycles(50);
  EXPECT_EQ(device.sample.q[0], q);
  EXPECT_NE(device.link.rig().joints().q[0], q);
}

TEST(SensorsDisagree, AStuckEncoderIsDistinguishedFromAJointAtRestByItsDrive) {
  SceneConfig scene = test::two_joints();
  for (DriveParams& drive : scene.device->rig->drives) drive.max_slip = 0.01;
  test::FaultyRig device(scene);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  EXPECT_FALSE(device.cycles_to_fault(2000)) << device.rig.fault_text();
  device.play("stuck bus=can0 node=2");
  ASSERT_TRUE(device.cycles_to_fault(300));
  EXPECT_EQ(device.rig.faults(), RigFault::sensors_disagree) << device.rig.fault_text();
  EXPECT_NE(device.rig.fault_text().find("can1 node 2, drive of elbow"), std::string::npos);
  EXPECT_TRUE(device.cycles_to_zero(test::cycles_of_watchdog));
}

TEST(SensorsDisagree, IsNotLookedForWhereTheSceneSaysSo) {
  SceneConfig scene = test::two_joints();
  for (DriveParams& drive : scene.device->rig->drives) drive.max_slip = 0;
  test::FaultyRig device(scene);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  device.play("stuck bus=can0 node=1");
  EXPECT_FALSE(device.cycles_to_fault(1000)) << device.rig.fault_text();
}

TEST(SensorsDisagree, AFrozenEncoderThatAnswersIsSeenByDefaultOnceItsJointHasMoved) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  EXPECT_FALSE(device.cycles_to_fault(2000)) << device.rig.fault_text();
  device.play("stuck bus=can0 node=2");
  device.cycle();
  const double before = device.link.rig().joints().q[1];
  ASSERT_TRUE(device.cycles_to_fault(300)) << "moved by " << device.link.rig().joints().q[1] - before;
  EXPECT_EQ(device.rig.faults(), RigFault::sensors_disagree) << device.rig.fault_text();
  EXPECT_LT(std::abs(device.link.rig().joints().q[1] - before), 0.07);
}

TEST(SensorsDisagree, AStuckDriveIsSeenTooAndDistanceBeforeReadyDoesNotCount) {
  SceneConfig scene = test::two_joints();
  for (DriveParams& drive : scene.device->rig->drives) {
    drive.max_slip = 0.01;
    drive.status_every_nth_sync = 4;
    drive.calibration.home = 0.5;  // of a motor that was switched on at any position
  }
  test::FaultyRig device(scene);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  EXPECT_FALSE(device.cycles_to_fault(2000)) << device.rig.fault_text();
  device.play("stuck bus=can1 node=1");
  ASSERT_TRUE(device.cycles_to_fault(300));
  EXPECT_EQ(device.rig.faults(), RigFault::sensors_disagree) << device.rig.fault_text();
}

TEST(FaultInjector, BeginsAndEndsInTime) {
  SceneConfig scene = test::two_joints();
  scene.faults = {{.verb = "drop", .bus = "can0", .node_id = 1, .at = 0.5, .duration = 0.002, .value = 1}};
  test::FaultyRig device(scene);
  ASSERT_TRUE(device.boot());
  while (device.motion_time < 0.4985) device.cycle();
  EXPECT_EQ(device.link.rig().faults().begun(), 0u);
  device.cycles(3);
  EXPECT_EQ(device.link.rig().faults().active().size(), 1u);
  device.cycles(2);
  EXPECT_TRUE(device.link.rig().faults().active().empty());
  EXPECT_FALSE(device.cycles_to_fault(100)) << "two samples are less than stale_after";
}

TEST(FaultInjector, ClearEndsWhatIsActiveAndForgetsWhatWaits) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot());
  device.play("nan bus=can0 node=1 at=1e3");
  device.play("spike bus=can1 node=2 duration=10");
  device.cycle();
  FaultInjector& faults = device.link.rig().faults();
  EXPECT_EQ(faults.active().size(), 1u);
  faults.clear(device.t_sync_ns);
  EXPECT_TRUE(faults.active().empty());
  device.motion_time = 2e3;
  device.cycle();
  EXPECT_TRUE(faults.active().empty());
}

TEST(FaultInjector, SaysWhenItIsFull) {
  test::FaultyRig device;
  std::string error;
  const SimFault fault = *resolve(*parse_fault("drop at=1", error), *device.scene.device->rig).fault;
  FaultInjector& faults = device.link.rig().faults();
  for (std::size_t i = 0; i < FaultInjector::capacity; ++i) EXPECT_TRUE(faults.schedule(fault));
  EXPECT_FALSE(faults.schedule(fault));
}

TEST(FaultInjector, DoesNotAllocate) {
  test::FaultyRig device;
  ASSERT_TRUE(device.boot());
  std::string error;
  const RigParams& rig = *device.scene.device->rig;
  for (const FaultVerbText& text : fault_verb_texts()) {
    if (text.place == FaultPlace::tracker) continue;
    const std::string node = text.place == FaultPlace::bus   ? ""
                             : text.verb == FaultVerb::press ? " node=3 value=1"
                                                             : " node=1";
    const std::string words = std::string(text.name) + " bus=can0" + node + " duration=0.002";
    const auto [fault, why_not] = resolve(*parse_fault(words, error), rig);
    ASSERT_TRUE(fault) << words << ": " << why_not;
    AllocationGuard guard;
    ASSERT_TRUE(device.link.rig().faults().schedule(*fault));
    device.cycles(5);
    EXPECT_EQ(guard.calls(), 0) << text.name << ": " << guard.report();
  }
}

}  // namespace
}  // namespace godobject::test_fault_injector
