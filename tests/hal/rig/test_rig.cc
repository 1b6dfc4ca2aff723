// The rig against a scripted bus: sent frames, attribution of frames, and faults.
#include "hal/rig/rig.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <type_traits>

#include "hal/canopen/cia401.h"
#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"
#include "tests/support/scripted_bus.h"

namespace godobject::test_rig {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds sync_bits = 48;       // on the wire, without the intermission
constexpr Nanoseconds answer_ns = 250'000;  // end of an answer on the wire, after its SYNC

// A hinge with encoder 1, and a hinge with drive 2 only.
RigParams two_joints() {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = {{.name = "yaw"}, {.name = "pitch", .axis_J = Vec3::UnitY()}};
  rig.tree.handles = {{.body = "tool", .joint = "pitch", .X_LH = {Vec3(0.1, 0, 0), Quat::Identity()}}};
  rig.encoders = {{.joint = "yaw", .node_id = 1, .calibration = {.counts_per_unit = 1000}}};
  rig.drives = {{.joint = "pitch",
                 .node_id = 2,
                 .torque_rate_Nm_per_s = 1000,
                 .calibration = {.counts_per_unit = 1000}}};
  return rig;
}

// A rig without its cycle, or with params that do not outlive it, does not compile.
using Buses = std::span<CanBus* const>;
static_assert(std::is_constructible_v<Rig, const RigParams&, double, Buses>);
static_assert(!std::is_constructible_v<Rig, const RigParams&, Buses>);
static_assert(!std::is_constructible_v<Rig, RigParams, double, Buses>);

class RigTest : public testing::Test {
 protected:
  explicit RigTest(RigParams of_rig = two_joints()) : params(std::move(of_rig)), rig(params, 1e-3, buses) {}

  void receive(const CanFrame& frame, Nanoseconds t_ns) { bus.to_receive.push_back({frame, t_ns}); }
  void heartbeats(canopen::NmtState state = canopen::NmtState::operational) {
    receive(canopen::make_heartbeat(1, state), now);
    receive(canopen::make_heartbeat(2, state), now);
  }
  /// Nodes answer nothing in a cycle without SYNC.
  bool sync_was_sent() const { return std::ranges::count(bus.sent, canopen::sync_cob_id, &CanFrame::id) > 0; }
  void answer_encoder() {
    if (!sync_was_sent()) return;
    receive(cia406::make_position(1, encoder_counts), now + answer_ns);
  }
  void answer_drive() {
    if (!sync_was_sent()) return;
    const unsigned statusword =
        cia402::encode_state(drive_state) | (drive_follows ? cia402::status_follows_command : 0u);
    receive(cia402::make_status(
                2, {.statusword = static_cast<std::uint16_t>(statusword), .position_counts = drive_counts}),
            now + answer_ns);
  }
  void finish_cycle() {
    rig.receive(now + ms / 2);
    sample = rig.read(now + ms / 2);
    bus.sent.clear();
    report = rig.command(std::span(&F, 1), now + ms / 2);
    now += ms;
  }
  void cycle() {
    rig.sync(now);
    answer_encoder();
    answer_drive();
    if (send_heartbeats && now % (100 * ms) == 0) heartbeats();
    finish_cycle();
    follow_controlword();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  void boot_and_arm() {
    rig.start(now);
    heartbeats();
    cycles(10 + Rig::settle_cycles);
    ASSERT_EQ(rig.state(), RigState::ready) << rig.fault_text();
    ASSERT_TRUE(rig.arm());
  }
  // Makes the drive follow its controlword one cycle later.
  void follow_controlword() {
    if (drive_is_dead) return;
    for (const CanFrame& frame : bus.sent) {
      cia402::Command command;
      if (cia402::parse_command(frame, 2, command) != ParseResult::ok) continue;
      last_command = command;
      switch (command.controlword) {
        case cia402::shutdown: drive_state = cia402::DriveState::ready_to_switch_on; break;
        case cia402::switch_on: drive_state = cia402::DriveState::switched_on; break;
        case cia402::enable_operation: drive_state = cia402::DriveState::operation_enabled; break;
        default: break;
      }
    }
  }

  test::ScriptedBus bus;
  std::array<CanBus*, 1> buses{&bus};
  const RigParams params;
  Rig rig;
  Nanoseconds now = 0;
  std::uint32_t encoder_counts = 0;
  std::int32_t drive_counts = 0;
  cia402::DriveState drive_state = cia402::DriveState::switch_on_disabled;
  bool drive_is_dead = false;
  bool drive_follows = true;
  bool send_heartbeats = true;
  cia402::Command last_command;
  Wrench F;
  DeviceSample sample;
  CommandReport report;
};

TEST_F(RigTest, SendsNothingWhileOff) {
  cycles(3);
  EXPECT_TRUE(bus.sent.empty());
  EXPECT_EQ(rig.state(), RigState::off);
}

TEST_F(RigTest, BootsByNmtThenControlwords) {
  send_heartbeats = false;
  rig.start(now);
  rig.sync(now);
  rig.read(now);
  ASSERT_GE(bus.sent.size(), 3u);
  EXPECT_EQ(bus.sent[0].id, canopen::sync_cob_id);  // first frame of the cycle
  EXPECT_EQ(bus.sent[1].id, canopen::heartbeat_cob_id(127));
  canopen::Nmt nmt;
  ASSERT_EQ(canopen::parse_nmt(bus.sent[2], nmt), ParseResult::ok);
  EXPECT_EQ(nmt.command, canopen::NmtCommand::start);
  EXPECT_EQ(nmt.node, 1);
  cycles(5);
  EXPECT_EQ(rig.state(), RigState::booting);  // samples, but no heartbeat yet
  EXPECT_EQ(drive_state, cia402::DriveState::switch_on_disabled);
  heartbeats();
  cycles(6 + Rig::settle_cycles);
  EXPECT_EQ(rig.state(), RigState::ready);
  EXPECT_EQ(drive_state, cia402::DriveState::operation_enabled);
  EXPECT_EQ(last_command.target_torque_per_mille, 0);
}

TEST_F(RigTest, EncoderAndDrivePositionsMakeThePose) {
  boot_and_arm();
  encoder_counts = 30;
  drive_counts = -20;
  cycle();
  EXPECT_DOUBLE_EQ(sample.q(0), 0.03);
  EXPECT_DOUBLE_EQ(sample.q(1), -0.02);
  EXPECT_TRUE(sample.valid);
  EXPECT_NEAR(sample.handles[0].X_WD.p.z(), 0.1 * std::sin(0.02), 1e-15);
}

TEST_F(RigTest, CommandIsTheJointTorque) {
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);  // 0.1 m arm about y: +0.02 N m
  cycles(3);
  EXPECT_EQ(last_command.target_torque_per_mille, 200);  // of 0.1 N m
}

TEST_F(RigTest, LateAnswerBelongsToTheSyncBefore) {
  boot_and_arm();
  rig.sync(now);
  answer_drive();
  finish_cycle();
  const Nanoseconds missed_sync_ns = now - ms;
  rig.sync(now);
  receive(cia406::make_position(1, 0), now - 1);  // was on the wire before this SYNC
  answer_drive();
  rig.receive(now + ms / 2);
  EXPECT_FALSE(rig.complete());
  const JointSample joint = rig.encoder(0).sample(now);
  EXPECT_LT(joint.t_ns, now);
  EXPECT_GT(joint.t_ns, missed_sync_ns);
  answer_encoder();
  rig.receive(now + ms / 2);
  EXPECT_TRUE(rig.complete());
}

TEST_F(RigTest, AnswerInFlightWhenSyncIsQueuedBelongsToTheSyncBefore) {
  boot_and_arm();
  cycle();
  rig.sync(now);
  answer_drive();
  finish_cycle();
  rig.sync(now);
  const CanFrame answer = cia406::make_position(1, 0);
  constexpr Nanoseconds in_flight_end_ns = 60'000;
  receive(answer, now + in_flight_end_ns);
  answer_drive();
  rig.receive(now + ms / 2);
  EXPECT_FALSE(rig.complete());
  EXPECT_EQ(rig.encoder(0).sample(now).t_ns, now - ms + sync_bits * 1000);
  answer_encoder();
  rig.receive(now + ms / 2);
  EXPECT_TRUE(rig.complete());
  EXPECT_EQ(rig.encoder(0).sample(now).t_ns, now + in_flight_end_ns + (intermission_bits + sync_bits) * 1000);
  EXPECT_EQ(rig.encoder(0).counters().out_of_order, 0u);
}

TEST_F(RigTest, RefusedSyncIsNotOneThatWentUnanswered) {
  boot_and_arm();
  const std::uint64_t syncs = rig.counters().syncs;
  bus.full = true;
  rig.sync(now);
  bus.full = false;
  receive(cia406::make_position(1, 7), now + answer_ns);  // a second answer to the previous SYNC
  finish_cycle();
  EXPECT_EQ(rig.counters().syncs, syncs);
  EXPECT_EQ(rig.counters().repeated, 1u);
  EXPECT_LT(sample.t_ns, now - ms - ms / 2);
  cycle();
  EXPECT_EQ(rig.counters().syncs, syncs + 1);
  EXPECT_EQ(rig.counters().incomplete_syncs, 0u);
  EXPECT_EQ(rig.faults(), RigFault::none);
}

TEST_F(RigTest, SyncRefusedRepeatedlyIsAFault) {
  boot_and_arm();
  bus.full = true;
  rig.sync(now);
  rig.sync(now + ms);
  EXPECT_EQ(rig.faults(), RigFault::none);
  rig.sync(now + 2 * ms);
  EXPECT_EQ(rig.faults(), RigFault::send_refused);
}

TEST_F(RigTest, ABabblingBusIsReadInPartsAndThatIsCounted) {
  boot_and_arm();
  const std::uint64_t frames = rig.counters().frames;
  rig.sync(now);
  for (int i = 0; i < Rig::max_frames_per_receive; ++i)
    receive(cia406::make_position(99, 0), now + answer_ns);
  answer_encoder();
  answer_drive();
  rig.receive(now + ms / 2);
  EXPECT_EQ(rig.counters().receive_truncated, 1u);
  EXPECT_EQ(rig.counters().frames, frames + Rig::max_frames_per_receive);
  EXPECT_FALSE(rig.complete());
  rig.receive(now + ms / 2);
  EXPECT_EQ(rig.counters().receive_truncated, 1u);
  EXPECT_TRUE(rig.complete());
}

TEST_F(RigTest, NotFiniteCommandIsBlamedOnNoBus) {
  boot_and_arm();
  F.f.x() = std::numeric_limits<double>::quiet_NaN();
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::command_not_finite);
  EXPECT_FALSE(rig.fault_log().first(RigFault::command_not_finite).place.bus.has_value());
  EXPECT_TRUE(rig.fault_text().starts_with("command_not_finite (host): ")) << rig.fault_text();
}

TEST_F(RigTest, LostHeartbeat) {
  boot_and_arm();
  send_heartbeats = false;
  cycles(650);
  EXPECT_EQ(rig.faults(), RigFault::heartbeat_lost);
  EXPECT_EQ(rig.fault_log().count(RigFault::heartbeat_lost), 1u);
}

TEST_F(RigTest, BootUpMessageWhileRunning) {
  boot_and_arm();
  receive(canopen::make_heartbeat(2, canopen::NmtState::boot_up), now);
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::node_restarted);
  EXPECT_EQ(rig.fault_log().first(RigFault::node_restarted).place.node_id, 2);
}

TEST_F(RigTest, EmergencyButNotTheAllClear) {
  boot_and_arm();
  receive(canopen::make_emergency({.node = 1}), now);
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::none);
  receive(canopen::make_emergency({.node = 1, .error_code = 0x4210}), now);
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::emergency);
  EXPECT_NE(rig.fault_text().find("code 0x4210"), std::string::npos) << rig.fault_text();
}

TEST_F(RigTest, DriveThatLeavesOperationEnabled) {
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);
  cycles(3);
  drive_is_dead = true;
  drive_state = cia402::DriveState::fault;
  cycles(2);
  EXPECT_EQ(rig.faults(), RigFault::drive_not_enabled);
  cia402::Command command;
  ASSERT_EQ(cia402::parse_command(bus.sent.back(), 2, command), ParseResult::ok);
  EXPECT_EQ(command.controlword, cia402::disable_voltage);
  EXPECT_EQ(command.target_torque_per_mille, 0);
}

TEST_F(RigTest, TorqueWaitsForADriveThatFollows) {
  drive_follows = false;
  rig.start(now);
  heartbeats();
  cycles(50);
  EXPECT_EQ(rig.state(), RigState::enabling);
  EXPECT_EQ(drive_state, cia402::DriveState::operation_enabled);
  drive_follows = true;
  cycles(Rig::settle_cycles);
  EXPECT_EQ(rig.state(), RigState::enabling);
  drive_follows = false;
  cycle();
  drive_follows = true;
  cycles(Rig::settle_cycles);
  EXPECT_EQ(rig.state(), RigState::enabling);
  cycle();
  EXPECT_EQ(rig.state(), RigState::ready);
  EXPECT_EQ(last_command.target_torque_per_mille, 0);
  ASSERT_TRUE(rig.arm());
  drive_follows = false;
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::drive_not_enabled);
}

TEST_F(RigTest, QuickStopIsCommandedUntilTheFaultIsCleared) {
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);
  cycles(3);
  ASSERT_NE(last_command.target_torque_per_mille, 0);
  rig.quick_stop();
  cycles(3);
  EXPECT_EQ(last_command.controlword, cia402::quick_stop);
  EXPECT_EQ(last_command.target_torque_per_mille, 0);
  EXPECT_EQ(rig.faults(), RigFault::quick_stop);
  rig.clear_faults(now);
  cycle();
  EXPECT_EQ(last_command.controlword, cia402::enable_operation);
}

/// After three periods without a good sample the pose is held; after 100 ms it is a fault.
TEST_F(RigTest, AGapInTheSamplesIsNoFaultBeforeLostAfter) {
  boot_and_arm();
  for (const bool encoder : {true, false})
    for (const int missing : {1, 3, 4, 50, 99}) {
      for (int k = 0; k < missing; ++k) {
        rig.sync(now);
        if (!encoder) answer_encoder();
        if (encoder) answer_drive();
        if (now % (100 * ms) == 0) heartbeats();
        finish_cycle();
        EXPECT_FALSE(sample.fresh);
        EXPECT_EQ(sample.valid, k < 2) << "read in the middle of the period";
      }
      cycle();
      EXPECT_TRUE(sample.valid && sample.fresh) << missing;
      ASSERT_EQ(rig.faults(), RigFault::none) << missing << rig.fault_text();
      cycles(10);
    }
}

TEST_F(RigTest, SilentDriveThatIsAlsoTheJointsSensor) {
  boot_and_arm();
  for (int k = 0; k < 106; ++k) {
    rig.sync(now);
    answer_encoder();
    if (now % (100 * ms) == 0) heartbeats();
    finish_cycle();
  }
  EXPECT_EQ(rig.faults(), RigFault::drive_silent | RigFault::sample_stale);
  EXPECT_FALSE(sample.valid);
}

TEST_F(RigTest, OneSpikeIsOneInvalidSampleThreeAreAFault) {
  boot_and_arm();
  encoder_counts = 5000;
  cycle();
  EXPECT_FALSE(sample.valid);
  EXPECT_EQ(sample.q(0), 0);
  encoder_counts = 0;
  cycles(10);
  EXPECT_TRUE(sample.valid);
  EXPECT_EQ(rig.faults(), RigFault::none);
  encoder_counts = 5000;
  cycles(3);
  EXPECT_EQ(rig.faults(), RigFault::sample_implausible);
  // the sensor is consistent from there on, but its jump must not move the tool
  cycles(100);
  EXPECT_FALSE(sample.valid);
  rig.clear_faults(now);
  cycles(100);
  EXPECT_TRUE(sample.valid);
}

TEST_F(RigTest, BusOff) {
  boot_and_arm();
  bus.bus_state = BusState::bus_off;
  cycle();
  EXPECT_EQ(rig.faults(), RigFault::bus_down);
}

TEST_F(RigTest, RefusedFramesAreCountedThenAFault) {
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);
  cycles(3);
  const double sent_torque = rig.commanded_torque_Nm(0);
  F.f = Vec3(0, 0, 0.2);
  rig.sync(now);
  answer_encoder();
  answer_drive();
  bus.full = true;
  finish_cycle();
  EXPECT_EQ(report.not_sent, 1u);
  EXPECT_EQ(rig.commanded_torque_Nm(0), sent_torque);
  EXPECT_EQ(rig.faults(), RigFault::none);
  cycles(2);
  EXPECT_EQ(rig.faults(), RigFault::send_refused);
}

TEST_F(RigTest, MalformedAndForeignFramesAreCounted) {
  boot_and_arm();
  CanFrame short_position = cia406::make_position(1, 0);
  short_position.size = 3;
  receive(short_position, now);
  receive(cia406::make_position(99, 0), now);
  CanFrame extended = cia406::make_position(1, 0);
  extended.extended = true;
  receive(extended, now);
  cycle();
  EXPECT_EQ(rig.counters().malformed, 1u);
  EXPECT_EQ(rig.counters().foreign, 2u);
  EXPECT_EQ(rig.faults(), RigFault::none);
}

TEST_F(RigTest, DisarmRunsTheTorqueDownWithoutAFault) {
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);
  cycles(3);
  ASSERT_NE(last_command.target_torque_per_mille, 0);
  rig.disarm();
  cycles(3);
  EXPECT_EQ(last_command.target_torque_per_mille, 0);
  EXPECT_EQ(rig.state(), RigState::ready);
}

TEST_F(RigTest, ASceneThatGainsEnergyRunsTheTorqueDown) {
  rig.energy_gained();
  EXPECT_EQ(rig.faults(), RigFault::none) << "no torque is on yet";
  boot_and_arm();
  F.f = Vec3(0, 0, -0.2);
  cycles(3);
  ASSERT_NE(last_command.target_torque_per_mille, 0);
  rig.energy_gained();
  cycles(3);
  EXPECT_EQ(last_command.target_torque_per_mille, 0);
  EXPECT_EQ(rig.faults(), RigFault::energy_gained);
}

TEST_F(RigTest, HostThatWokeLateIsNoFaultOfTheDevice) {
  boot_and_arm();
  now += 20 * ms;
  cycles(3);
  EXPECT_EQ(rig.faults(), RigFault::none) << rig.fault_text();
}

RigParams with_slow_status() {
  RigParams params = two_joints();
  params.drives[0].status_every_nth_sync = 3;
  return params;
}

class SlowStatusTest : public RigTest {
 protected:
  SlowStatusTest() : RigTest(with_slow_status()) {}
};

TEST_F(SlowStatusTest, CompleteDoesNotWaitForAnAnswerThatIsNotDue) {
  boot_and_arm();
  for (int k = 0; k < 3; ++k) {
    rig.sync(now);
    answer_encoder();
    rig.receive(now + ms / 2);
    EXPECT_EQ(rig.complete(), k < 2) << k;
    finish_cycle();
  }
}

RigParams with_buttons() {
  RigParams params = two_joints();
  params.buttons = {{.node_id = 3, .bit = 2},
                    {.use = ButtonUse::clutch, .node_id = 3, .bit = 0, .active_low = true}};
  return params;
}

class ButtonTest : public RigTest {
 protected:
  ButtonTest() : RigTest(with_buttons()) {}
};

TEST_F(ButtonTest, AreInputsOfOneNodeThatTheRigWaitsFor) {
  EXPECT_TRUE(rig.has_button(ButtonUse::hold) && rig.has_button(ButtonUse::clutch));
  rig.start(now);
  heartbeats();
  receive(canopen::make_heartbeat(3, canopen::NmtState::operational), now);
  cycles(10);
  EXPECT_EQ(rig.state(), RigState::booting);
  receive(cia401::make_inputs(3, 0b001), now);
  cycles(10);
  EXPECT_NE(rig.state(), RigState::booting);
  EXPECT_FALSE(sample.buttons.hold || sample.buttons.clutch);
  receive(cia401::make_inputs(3, 0b100), now);
  cycle();
  EXPECT_TRUE(sample.buttons.hold && sample.buttons.clutch);
  receive(cia401::make_inputs(3, 0b001), now);
  cycle();
  EXPECT_FALSE(sample.buttons.hold || sample.buttons.clutch);
}

TEST_F(ButtonTest, LostButtonNodeIsNamed) {
  rig.start(now);
  heartbeats();
  receive(canopen::make_heartbeat(3, canopen::NmtState::operational), now);
  receive(cia401::make_inputs(3, 0), now);
  cycles(650);
  EXPECT_EQ(rig.faults(), RigFault::heartbeat_lost);
  EXPECT_NE(rig.fault_text().find("node 3, button"), std::string::npos) << rig.fault_text();
}

TEST(RigFault, EveryBitHasItsTextsInOrder) {
  std::set<std::string_view> names;
  std::uint32_t bit = 1;
  for (const RigFaultText& text : rig_fault_texts()) {
    EXPECT_EQ(static_cast<std::uint32_t>(text.fault), bit);
    EXPECT_TRUE(names.insert(text.name).second) << text.name;
    EXPECT_FALSE(text.meaning.empty() || text.remedy.empty()) << text.name;
    bit <<= 1;
  }
}

TEST(RigFaultLog, KeepsEveryPlaceOnceInTheOrderInWhichTheyCameUp) {
  RigFaultLog log;
  EXPECT_TRUE(log.raise({.fault = RigFault::sample_stale, .bus = 0, .node_id = 2}, 5));
  EXPECT_TRUE(log.raise({.fault = RigFault::bus_down, .bus = 1}, 6));
  EXPECT_FALSE(log.raise({.fault = RigFault::sample_stale, .bus = 0, .node_id = 2}, 7));
  EXPECT_TRUE(log.raise({.fault = RigFault::sample_stale, .bus = 1, .node_id = 2}, 8));
  ASSERT_EQ(log.records().size(), 3u);
  EXPECT_EQ(log.records()[0].t_ns, 5);
  EXPECT_EQ(log.records()[1].place.fault, RigFault::bus_down);
  EXPECT_EQ(log.records()[2].place.bus, 1u);
  EXPECT_EQ(log.count(RigFault::sample_stale), 1u);
  EXPECT_EQ(log.first(RigFault::sample_stale).t_ns, 5);
  log.clear();
  EXPECT_EQ(log.faults(), RigFault::none);
  EXPECT_TRUE(log.records().empty());
  EXPECT_TRUE(log.raise({.fault = RigFault::sample_stale, .bus = 0, .node_id = 2}, 9));
  EXPECT_EQ(log.count(RigFault::sample_stale), 2u);
}

TEST(RigFaultLog, CountsThePlacesThatItHasNoRoomFor) {
  RigFaultLog log;
  for (std::size_t i = 0; i < RigFaultLog::capacity + 3; ++i)
    log.raise({.fault = RigFault::emergency, .bus = 0, .emcy_code = static_cast<std::uint16_t>(i)}, 0);
  EXPECT_EQ(log.records().size(), RigFaultLog::capacity);
  EXPECT_EQ(log.left_out(), 3u);
}

}  // namespace
}  // namespace godobject::test_rig
