#include "sim/node/drive.h"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

namespace godobject::test_sim_drive {
namespace {

using canopen::NmtCommand;
using cia402::DriveState;

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint8_t node = 5;

SimDriveParams drive_params() {
  SimDriveParams params;
  params.drive.node_id = node;
  params.drive.torque_rated_Nm = 0.1;
  params.drive.torque_max_Nm = 0.05;
  params.drive.calibration.counts_per_unit = 1000;
  params.rpdo_timeout_ns = 20 * ms;
  return params;
}

/// A host that runs 1 ms cycles: SYNC, then the command, over the wire to one drive.
struct Rig {
  explicit Rig(const SimDriveParams& params = drive_params()) : drive(port, params) {
    EXPECT_TRUE(host.open() && port.open());
    run_to(1 * ms);
    send(canopen::make_nmt(NmtCommand::start, node));
    run_to(2 * ms);
    read();
  }

  void run_to(Nanoseconds t) {
    advance(wire, nodes, t);
    read();
  }
  void send(const CanFrame& frame) { ASSERT_EQ(host.try_send(frame), SendResult::queued); }
  void cycle(std::optional<cia402::Command> command = {}) {
    const Nanoseconds start = wire.now();
    send(canopen::make_sync());
    if (command) send(cia402::make_command(node, *command));
    run_to(start + ms);
  }
  void enable() {
    for (int i = 0; i < 20 && drive.drive_state() != DriveState::operation_enabled; ++i) {
      controlword = cia402::next_controlword(cia402::decode_state(status.statusword), controlword, true);
      cycle(cia402::Command{.controlword = controlword});
    }
    ASSERT_EQ(drive.drive_state(), DriveState::operation_enabled);
  }
  void read() {
    for (ReceivedFrame received; host.try_receive(received);) {
      canopen::Emergency emergency;
      if (cia402::parse_status(received.frame, node, status) == ParseResult::ok) statuses.push_back(status);
      if (cia402::parse_event(received.frame, node, event) == ParseResult::ok) ++events;
      if (canopen::parse_emergency(received.frame, emergency) == ParseResult::ok) {
        emergencies.push_back(emergency);
        t_emergency = received.t_ns;
      }
    }
  }

  SimCanWire wire{{}};
  SimCanPort host{wire}, port{wire};
  SimDrive drive;
  SimCanopenNode* nodes[1] = {&drive};
  std::uint16_t controlword = 0;
  cia402::Status status;
  cia402::Event event;
  std::vector<cia402::Status> statuses;
  std::vector<canopen::Emergency> emergencies;
  Nanoseconds t_emergency = 0;
  int events = 0;
};

cia402::Command torque(std::int16_t per_mille) {
  return {.controlword = cia402::enable_operation, .target_torque_per_mille = per_mille};
}

TEST(SimDrive, IsEnabledOverTheBus) {
  Rig rig;
  rig.enable();
  rig.cycle(torque(0));
  std::vector<DriveState> states;
  for (const cia402::Status& s : rig.statuses) {
    const DriveState state = cia402::decode_state(s.statusword);
    if (states.empty() || states.back() != state) states.push_back(state);
  }
  EXPECT_EQ(states, (std::vector{DriveState::switch_on_disabled, DriveState::ready_to_switch_on,
                                 DriveState::switched_on, DriveState::operation_enabled}));
  EXPECT_NE(rig.status.statusword & cia402::status_follows_command, 0);
}

TEST(SimDrive, CommandTakesEffectAtTheNextSync) {
  Rig rig;
  rig.enable();
  rig.cycle(torque(200));
  EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
  const Nanoseconds start = rig.wire.now();
  rig.send(canopen::make_sync());
  rig.run_to(start + ms / 2);
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.02);
  EXPECT_EQ(rig.status.actual_torque_per_mille, 0);  // of the cycle that has just ended
  rig.run_to(start + ms);
  rig.cycle(torque(0));
  EXPECT_EQ(rig.status.actual_torque_per_mille, 200);
}

TEST(SimDrive, OnlyTheLastCommandBeforeSyncCounts) {
  Rig rig;
  rig.enable();
  rig.send(cia402::make_command(node, torque(400)));
  rig.send(cia402::make_command(node, torque(100)));
  rig.run_to(rig.wire.now() + ms);
  rig.cycle();
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.01);
}

TEST(SimDrive, NoTorqueUnlessEnabled) {
  Rig rig;
  for (const std::uint16_t word : {cia402::shutdown, cia402::switch_on}) {
    for (int i = 0; i < 3; ++i) {
      rig.cycle(cia402::Command{.controlword = word, .target_torque_per_mille = 300});
      EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
    }
  }
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switched_on);
  rig.cycle(torque(300));
  rig.cycle(torque(300));
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.03);
  rig.cycle(cia402::Command{.controlword = cia402::quick_stop, .target_torque_per_mille = 300});
  rig.cycle();
  EXPECT_EQ(rig.drive.drive_state(), DriveState::quick_stop_active);
  EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
}

TEST(SimDrive, EnableCommandAloneDoesNotEnable) {
  Rig rig;
  for (int i = 0; i < 5; ++i) rig.cycle(torque(300));
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
}

TEST(SimDrive, TorqueSaturatesAndSaysSo) {
  Rig rig;
  rig.enable();
  rig.cycle(torque(500));
  rig.cycle(torque(501));
  rig.cycle(torque(-32768));
  EXPECT_EQ(rig.status.statusword & cia402::status_internal_limit, 0);
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.05);
  rig.cycle();
  EXPECT_NE(rig.status.statusword & cia402::status_internal_limit, 0);
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), -0.05);
}

TEST(SimDrive, WatchdogTripsWithoutCommands) {
  Rig rig;
  rig.enable();
  rig.cycle(torque(300));
  rig.cycle(torque(300));
  const Nanoseconds last_command = rig.wire.now() - ms;
  while (rig.wire.now() < last_command + 20 * ms) rig.cycle();
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.03);
  rig.cycle();
  EXPECT_EQ(rig.drive.drive_state(), DriveState::fault);
  EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
  ASSERT_EQ(rig.emergencies.size(), 1u);
  EXPECT_EQ(rig.emergencies[0].error_code, 0x8250);
  EXPECT_EQ(rig.emergencies[0].error_register, 0x11);
  EXPECT_EQ(cia402::decode_state(rig.status.statusword), DriveState::operation_enabled);
  rig.cycle();
  EXPECT_EQ(cia402::decode_state(rig.status.statusword), DriveState::fault);
}

TEST(SimDrive, WithoutADeadlineItKeepsItsTorque) {
  SimDriveParams params = drive_params();
  params.rpdo_timeout_ns = SimDriveParams{}.rpdo_timeout_ns;
  Rig rig(params);
  rig.enable();
  rig.cycle(torque(300));
  rig.cycle(torque(300));
  rig.run_to(rig.wire.now() + 10'000 * ms);
  EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), 0.03);
  EXPECT_TRUE(rig.emergencies.empty());
}

TEST(SimDrive, WatchdogActsAtItsOwnTimeWithoutSync) {
  SimDriveParams params = drive_params();
  params.rpdo_timeout_ns = 7 * ms;
  Rig rig(params);
  rig.enable();
  const Nanoseconds enabled = rig.wire.now();
  rig.run_to(enabled + 50 * ms);
  // The last command arrived within the last cycle; the emergency takes the wire for at most 135 us.
  EXPECT_GT(rig.t_emergency, enabled - ms + 7 * ms);
  EXPECT_LT(rig.t_emergency, enabled + 7 * ms + 135'000);
}

TEST(SimDrive, WatchdogSleepsWhileThePowerStageIsOff) {
  Rig rig;
  rig.cycle(cia402::Command{.controlword = cia402::shutdown});
  rig.cycle(cia402::Command{.controlword = cia402::shutdown});
  rig.run_to(rig.wire.now() + 500 * ms);
  EXPECT_EQ(rig.drive.drive_state(), DriveState::ready_to_switch_on);
  EXPECT_TRUE(rig.emergencies.empty());
}

TEST(SimDrive, FaultIsLeftByARisingEdgeOnly) {
  Rig rig;
  rig.enable();
  rig.cycle(cia402::Command{.controlword = 0x8F});  // bit 7 is already set when the fault occurs
  rig.cycle(cia402::Command{.controlword = 0x8F});
  rig.drive.trip(0x2310);
  for (int i = 0; i < 5; ++i) rig.cycle(cia402::Command{.controlword = 0x80});
  EXPECT_EQ(rig.drive.drive_state(), DriveState::fault);
  EXPECT_EQ(rig.drive.error_code(), 0x2310);
  rig.cycle(cia402::Command{.controlword = 0x00});
  rig.cycle(cia402::Command{.controlword = 0x80});
  rig.cycle();
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
  EXPECT_EQ(rig.emergencies.back().error_code, 0);
  rig.enable();
}

TEST(SimDrive, HostRecoversFromAFaultByTheEnableSequence) {
  Rig rig;
  rig.enable();
  rig.drive.trip(0x2310);
  rig.cycle();
  rig.enable();
  EXPECT_EQ(rig.drive.error_code(), 0);
}

TEST(SimDrive, LeavingOperationalSwitchesOff) {
  for (const NmtCommand command :
       {NmtCommand::stop, NmtCommand::enter_pre_operational, NmtCommand::reset_node}) {
    Rig rig;
    rig.enable();
    rig.cycle(torque(300));
    rig.cycle(torque(300));
    ASSERT_GT(rig.drive.applied_torque_Nm(), 0);
    rig.send(canopen::make_nmt(command, 0));
    rig.run_to(rig.wire.now() + ms);
    EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
    rig.send(canopen::make_nmt(NmtCommand::start, 0));
    rig.run_to(rig.wire.now() + ms);
    rig.cycle();
    rig.cycle();
    EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);  // the old command has no effect
    EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
  }
}

TEST(SimDrive, ResetForgetsCommands) {
  Rig rig;
  rig.cycle(cia402::Command{.controlword = 0x80});
  rig.cycle(cia402::Command{.controlword = cia402::shutdown});  // 80h in effect, shutdown waits for SYNC
  rig.send(canopen::make_nmt(NmtCommand::reset_node, node));
  rig.send(canopen::make_nmt(NmtCommand::start, node));
  rig.run_to(rig.wire.now() + ms);
  rig.cycle();
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
  rig.drive.trip(0x2310);
  rig.cycle(cia402::Command{.controlword = 0x80});  // a rising edge again
  rig.cycle();
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
}

TEST(SimDrive, StatusIsSampledAtSyncEveryNth) {
  SimDriveParams params = drive_params();
  params.drive.status_every_nth_sync = 3;
  Rig rig(params);
  for (int i = 1; i <= 12; ++i) {
    rig.drive.set_joint(0.01 * i, 0);
    rig.cycle();
  }
  ASSERT_EQ(rig.statuses.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rig.statuses[i].position_counts, static_cast<int>(30 * (i + 1)));
  }
}

TEST(SimDrive, EventTimerReportsVelocityModeAndError) {
  Rig rig;
  rig.drive.set_joint(0, -1.5);
  rig.run_to(102 * ms + ms / 2);
  EXPECT_EQ(rig.events, 5);
  EXPECT_EQ(rig.event.velocity_counts_per_s, -1500);
  EXPECT_EQ(rig.event.mode, 10);
  EXPECT_EQ(rig.event.error_code, 0);
  rig.drive.trip(0x2310);
  rig.run_to(123 * ms);
  EXPECT_EQ(rig.event.error_code, 0x2310);
}

TEST(SimDrive, CommandsOfTheWrongSizeAreRefusedWithAnEmergency) {
  Rig rig;
  rig.enable();
  CanFrame frame = cia402::make_command(node, torque(300));
  for (const auto& [size, code] : {std::pair<std::uint8_t, std::uint16_t>{3, 0x8210}, {5, 0x8220}}) {
    frame.size = size;
    rig.send(frame);
    rig.run_to(rig.wire.now() + ms);
    rig.cycle();
    EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
    EXPECT_EQ(rig.emergencies.back().error_code, code);
  }
}

// Modes other than CST. The test sets the motor's position.

template <class T>  // of the object's size
void set(Rig& rig, canopen::ObjectAddress object, T value) {
  std::array<std::uint8_t, sizeof(T)> bytes{};
  ByteWriter(bytes).put(value);
  ASSERT_EQ(rig.drive.objects().write(object, bytes), sdo::AbortCode::none);
}

void motion_cycle(Rig& rig, cia402::CommandKind kind, std::int32_t target) {
  const Nanoseconds start = rig.wire.now();
  rig.send(canopen::make_sync());
  rig.send(cia402::make_motion_command(
      node, {.kind = kind, .controlword = cia402::enable_operation, .target = target}));
  rig.run_to(start + ms);
}

TEST(SimDrive, VelocityAndPositionTargetsPullTheMotor) {
  for (const cia402::CommandKind kind : {cia402::CommandKind::velocity, cia402::CommandKind::position}) {
    Rig rig;
    set(rig, {0x6060, 0}, static_cast<std::int8_t>(cia402::mode_of(kind)));
    rig.enable();
    for (const int sign : {1, -1}) {
      for (int i = 0; i < 3; ++i) motion_cycle(rig, kind, sign * 200);
      EXPECT_GT(sign * rig.drive.applied_torque_Nm(), 0);
      for (int i = 0; i < 3; ++i) motion_cycle(rig, kind, sign * 1'000'000);
      EXPECT_DOUBLE_EQ(rig.drive.applied_torque_Nm(), sign * 0.05);  // torque_max_Nm
    }
    for (int i = 0; i < 3; ++i) motion_cycle(rig, kind, 0);
    EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);
    for (int i = 0; i < 3; ++i) rig.cycle(torque(300));
    EXPECT_EQ(rig.drive.applied_torque_Nm(), 0);  // torque is not its mode
  }
}

TEST(SimDrive, HomingMakesThisThePositionOf607Ch) {
  Rig rig;
  rig.drive.set_joint(0.5, 0);
  set(rig, {0x6060, 0}, std::int8_t{6});
  set(rig, {0x607C, 0}, std::int32_t{1000});
  cia402::Homing homing(100 * ms);
  rig.cycle();
  for (int i = 0; i < 50 && !homing.finished(); ++i)
    rig.cycle(cia402::Command{.controlword = homing.step(rig.status.statusword, rig.wire.now())});
  EXPECT_EQ(homing.result(), cia402::Homing::Result::complete);
  rig.cycle();
  EXPECT_EQ(rig.status.position_counts, 1000);
  rig.drive.set_joint(0.6, 0);
  rig.cycle();
  EXPECT_EQ(rig.status.position_counts, 1100);
}

TEST(SimDrive, HomingByAMethodItDoesNotHaveFails) {
  Rig rig;
  set(rig, {0x6060, 0}, std::int8_t{6});
  set(rig, {0x6098, 0}, cia402::homing_at_index_positive);
  cia402::Homing homing(100 * ms);
  rig.cycle();
  for (int i = 0; i < 50 && !homing.finished(); ++i)
    rig.cycle(cia402::Command{.controlword = homing.step(rig.status.statusword, rig.wire.now())});
  EXPECT_EQ(homing.result(), cia402::Homing::Result::failed);
}

TEST(SimDrive, OutsideOperationalItIsCommandedBySdoAndMissesNoPdo) {
  Rig rig;
  rig.send(canopen::make_nmt(NmtCommand::enter_pre_operational, node));
  rig.run_to(rig.wire.now() + ms);
  for (const std::uint16_t word : {cia402::shutdown, cia402::switch_on, cia402::enable_operation})
    set(rig, {0x6040, 0}, word);
  rig.run_to(rig.wire.now() + 100 * ms);
  EXPECT_EQ(rig.drive.drive_state(), DriveState::operation_enabled);
  EXPECT_TRUE(rig.emergencies.empty());
  set(rig, {0x6040, 0}, cia402::quick_stop);
  EXPECT_EQ(rig.drive.drive_state(), DriveState::quick_stop_active);
  rig.run_to(rig.wire.now() + 2 * ms);
  EXPECT_EQ(rig.drive.drive_state(), DriveState::switch_on_disabled);
}

TEST(SimDrive, QuickStopEndsAsItsOptionSays) {
  for (const std::int16_t option : {std::int16_t{2}, std::int16_t{6}}) {
    Rig rig;
    set(rig, {0x605A, 0}, option);
    rig.enable();
    for (int i = 0; i < 6; ++i) rig.cycle(cia402::Command{.controlword = cia402::quick_stop});
    EXPECT_EQ(rig.drive.drive_state(),
              option == 2 ? DriveState::switch_on_disabled : DriveState::quick_stop_active);
  }
}

}  // namespace
}  // namespace godobject::test_sim_drive
