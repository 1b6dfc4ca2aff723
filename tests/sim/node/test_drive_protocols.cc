// Rigs with drives of each protocol: booting, holding torque, and switching off.
#include <gtest/gtest.h>

#include <numbers>

#include "hal/drive/odrive.h"
#include "hal/rig/bus_load.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_drive_protocols {
namespace {

using test::FaultyRig;

SceneConfig scene_with(DriveProtocol protocol) {
  SceneConfig scene = test::two_joints();
  RigParams& rig = *scene.device->rig;
  if (protocol == DriveProtocol::moteus) rig.buses[1].data_bit_rate = 5e6;
  for (DriveParams& drive : rig.drives) {
    drive.protocol = protocol;
    if (protocol != DriveProtocol::cia402) drive.profile.clear();
    if (protocol == DriveProtocol::odrive) drive.watchdog = DriveWatchdog::drive;
    drive.calibration.counts_per_unit =
        counts_per_motor_turn / (2 * std::numbers::pi * drive.joint_per_motor_rad);
  }
  return scene;
}

class DriveProtocols : public testing::TestWithParam<DriveProtocol> {
 protected:
  bool canopen() const { return bus_protocol(GetParam()).canopen; }

  FaultyRig device{scene_with(GetParam())};
};

TEST_P(DriveProtocols, BootsArmsAndHoldsTorque) {
  ASSERT_EQ(validate(*device.scene.device->rig, FaultyRig::period_s), std::vector<std::string>{});
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  const std::uint64_t incomplete = device.rig.counters().incomplete_syncs;
  device.cycles(500);
  EXPECT_EQ(device.rig.faults(), RigFault::none) << device.rig.fault_text();
  EXPECT_EQ(device.rig.counters().incomplete_syncs, incomplete);
  EXPECT_EQ(device.rig.counters().malformed, 0u);
  EXPECT_EQ(device.rig.counters().foreign, 0u);
  device.F_hand_W = {};
  device.F_hand_W.f = Vec3(0, 2, 0);
  device.cycles(30);
  for (std::size_t i = 0; i < 2; ++i) {
    const DriveFeedback feedback = device.rig.drive_feedback(i, device.t_sync_ns);
    EXPECT_TRUE(feedback.state == MotorState::enabled && feedback.position.valid);
    EXPECT_NEAR(feedback.position.q, device.link.rig().joints().q[static_cast<Eigen::Index>(i)], 2e-3);
    EXPECT_NEAR(feedback.torque_Nm, device.rig.commanded_torque_Nm(i), 3e-3);
    EXPECT_NEAR(device.link.rig().applied_torque_Nm(i), device.rig.commanded_torque_Nm(i), 3e-3);
  }
  EXPECT_GT(device.rig.commanded_torque_Nm(0), 0.01);  // the checks above are not vacuous
}

TEST_P(DriveProtocols, LoadIsWhatTheBusCarries) {
  ASSERT_TRUE(device.boot());
  const double before_s = 1e-9 * static_cast<double>(device.t_sync_ns);
  const double before = device.link.load_percent(1) * before_s;
  device.cycles(1000);
  const double now_s = 1e-9 * static_cast<double>(device.t_sync_ns);
  const double measured = (device.link.load_percent(1) * now_s - before) / (now_s - before_s);
  const RigParams& rig = *device.scene.device->rig;
  const BusLoad computed = bus_load(rig, FaultyRig::period_s, usual_load(rig))[1];
  EXPECT_GE(measured, 0.98 * computed.nominal_percent);
  EXPECT_LE(measured, 1.01 * computed.worst_percent);
}

TEST_P(DriveProtocols, AnUnpluggedDriveIsAFaultAndItsMotorStopsByItself) {
  ASSERT_TRUE(device.boot());
  device.play("unplug bus=can1 node=2");
  const auto cycles = device.cycles_to_fault(120);
  ASSERT_TRUE(cycles);
  EXPECT_GE(*cycles, 100) << "lost_after";
  EXPECT_LE(*cycles, 108);
  EXPECT_TRUE(any(device.rig.faults() & RigFault::drive_silent)) << device.rig.fault_text();
  EXPECT_TRUE(device.cycles_to_zero(25)) << device.motor_torque();
}

// Its absence is shorter than lost_after, so the host notices it by the state of the drive.
TEST_P(DriveProtocols, APowerCycledDriveStaysOffUntilItIsArmed) {
  ASSERT_TRUE(device.boot());
  device.play("reboot-node bus=can1 node=2 duration=0.05");
  device.cycles(2);
  EXPECT_EQ(device.link.rig().applied_torque_Nm(1), 0);
  EXPECT_TRUE(device.cycles_to_fault(120)) << device.motor_torque();
  device.cycles(100);
  EXPECT_EQ(device.motor_torque(), 0);
  device.rig.clear_faults(device.t_sync_ns);
  EXPECT_TRUE(device.boot()) << device.rig.fault_text();
}

TEST_P(DriveProtocols, WithoutTheHostEveryMotorStops) {
  ASSERT_TRUE(device.boot());
  for (int i = 0; i < 25; ++i) static_cast<void>(device.link.begin_cycle(device.motion_time));
  EXPECT_EQ(device.motor_torque(), 0);
  EXPECT_TRUE(device.cycles_to_fault(200));  // the drives have tripped and report it
  device.rig.clear_faults(device.t_sync_ns);
  EXPECT_TRUE(device.boot()) << device.rig.fault_text();
}

TEST_P(DriveProtocols, AnErrorOfADriveStopsAllAndCanBeCleared) {
  ASSERT_TRUE(device.boot());
  device.play("emcy bus=can1 node=1 value=33");
  ASSERT_TRUE(device.cycles_to_fault(150));
  const RigFault expected = canopen() ? RigFault::emergency : RigFault::drive_error;
  EXPECT_TRUE(any(device.rig.faults() & expected)) << device.rig.fault_text();
  const RigFaultPlace place = device.rig.fault_log().first(expected).place;
  EXPECT_EQ(place.node_id, 1);
  EXPECT_EQ(canopen() ? place.emcy_code : place.drive_code, 33u);
  EXPECT_TRUE(device.cycles_to_zero(25));
  device.rig.clear_faults(device.t_sync_ns);
  EXPECT_TRUE(device.boot()) << device.rig.fault_text();
}

TEST_P(DriveProtocols, NotANumberIsRefusedAndThenMissed) {
  if (canopen()) GTEST_SKIP() << "its positions are integers";
  ASSERT_TRUE(device.boot());
  device.play("nan bus=can1 node=1");
  ASSERT_TRUE(device.cycles_to_fault(120));
  EXPECT_EQ(device.rig.faults(), RigFault::drive_silent) << device.rig.fault_text();
  EXPECT_GT(device.rig.counters().malformed, 0u);
  EXPECT_TRUE(device.cycles_to_zero(25));
}

TEST_P(DriveProtocols, QuickStopTakesTheTorqueAwayAtOnceAndAwaitsTheUser) {
  ASSERT_TRUE(device.boot());
  device.rig.quick_stop();
  EXPECT_EQ(device.rig.faults(), RigFault::quick_stop);
  EXPECT_TRUE(device.cycles_to_zero(2));
  device.cycles(300);
  EXPECT_EQ(device.motor_torque(), 0);
  EXPECT_EQ(device.rig.faults(), RigFault::quick_stop) << device.rig.fault_text();
  EXPECT_FALSE(device.rig.arm());
  device.rig.clear_faults(device.t_sync_ns);
  EXPECT_TRUE(device.boot()) << device.rig.fault_text();
}

TEST_P(DriveProtocols, StopSwitchesTheMotorsOff) {
  ASSERT_TRUE(device.boot());
  device.rig.stop();
  static_cast<void>(device.link.begin_cycle(device.motion_time));
  device.cycles(3);
  EXPECT_EQ(device.rig.state(), RigState::off);
  EXPECT_EQ(device.motor_torque(), 0);
}

TEST_P(DriveProtocols, TheCycleDoesNotAllocate) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "malloc belongs to a sanitizer";
  AllocationGuard guard;
  const bool booted = device.boot();
  device.rig.quick_stop();
  device.cycles(50);
  device.rig.clear_faults(device.t_sync_ns);
  device.cycles(50);
  const long calls = guard.calls();
  EXPECT_EQ(calls, 0) << guard.report();
  EXPECT_TRUE(booted);
}

INSTANTIATE_TEST_SUITE_P(Each, DriveProtocols,
                         testing::Values(DriveProtocol::cia402, DriveProtocol::odrive, DriveProtocol::moteus),
                         [](const auto& param) {
                           return drive_protocol_names[static_cast<std::size_t>(param.param)];
                         });

struct SeenIds {
  std::vector<std::uint32_t> ids;
  static void on_frame(void* context, std::size_t bus, const ReceivedFrame& received) {
    if (bus == 1) static_cast<SeenIds*>(context)->ids.push_back(received.frame.id);
  }
};

TEST(DriveProtocolsOnTheWire, NothingOfCanopenIsSentToDrivesOfAnotherKind) {
  FaultyRig device(scene_with(DriveProtocol::odrive));
  SeenIds seen;
  device.link.set_observer({.on_frame = SeenIds::on_frame, .context = &seen});
  ASSERT_TRUE(device.boot());
  device.rig.stop();
  device.cycles(2);
  ASSERT_FALSE(seen.ids.empty());
  for (const std::uint32_t id : seen.ids) ASSERT_TRUE(id >> 5 == 1 || id >> 5 == 2) << std::hex << id;
}

// A drive is the only sensor of its joint if that has no encoder.
TEST(DriveProtocolsOnTheWire, TheDrivesOwnPositionIsASensor) {
  for (const DriveProtocol protocol : {DriveProtocol::odrive, DriveProtocol::moteus}) {
    SceneConfig scene = scene_with(protocol);
    scene.device->rig->encoders.pop_back();
    FaultyRig device(scene);
    ASSERT_TRUE(device.boot()) << device.rig.fault_text();
    for (int k = 0; k < 500; ++k) {
      device.cycle();
      ASSERT_TRUE(device.sample.valid) << device.rig.fault_text();
      ASSERT_LT(device.sample.age, 1'000'000);
      ASSERT_NEAR(device.sample.q(1), device.link.rig().joints().q(1), 2e-4);
    }
  }
}

}  // namespace
}  // namespace godobject::test_drive_protocols
