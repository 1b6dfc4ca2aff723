// Frames that a rig receives: their node, the SYNC that they answer, and the faults that they raise.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "tests/support/rig_on_buses.h"

namespace godobject::test_receive {
namespace {

using canopen::NmtState;
using cia402::DriveState;
using test::RigOnBuses;
using test::row_of_hinges;
using test::row_on_two_buses;

constexpr Nanoseconds ms = RigOnBuses::ms, us = RigOnBuses::us;

/// Records of one fault.
std::vector<RigFaultRecord> records_of(const Rig& rig, RigFault fault) {
  std::vector<RigFaultRecord> found;
  for (const RigFaultRecord& record : rig.fault_log().records())
    if (record.place.fault == fault) found.push_back(record);
  return found;
}

/// Two encoders with the same node id on two buses, and a drive on the second.
RigParams on_two_buses() {
  RigParams params = row_on_two_buses(1);
  params.encoders[1].node_id = params.encoders[0].node_id;
  return params;
}

TEST(ReceivedEmergency, IsAttributedToItsNodeAndBus) {
  for (const std::size_t from : {0u, 1u}) {
    RigOnBuses world(on_two_buses());
    ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
    world.receive(from, canopen::make_emergency({.node = 1, .error_code = 0x5112}));
    world.cycle();
    ASSERT_EQ(world.rig.faults(), RigFault::emergency);
    EXPECT_EQ(world.rig.fault_log().records()[0].place,
              (RigFaultPlace{.fault = RigFault::emergency, .bus = from, .node_id = 1, .emcy_code = 0x5112}));
    EXPECT_EQ(world.rig.state(), RigState::fault);
  }
}

TEST(ReceivedEmergency, HasOneRecordForEachCode) {
  RigOnBuses world(row_of_hinges(1, 1));
  ASSERT_TRUE(world.boot_and_arm());
  for (const std::uint16_t code : std::initializer_list<std::uint16_t>{0x5112, 0x8110, 0x5112})
    world.receive(0, canopen::make_emergency({.node = 1, .error_code = code}));
  world.cycle();
  const auto records = records_of(world.rig, RigFault::emergency);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].place.emcy_code, 0x5112);
  EXPECT_EQ(records[1].place.emcy_code, 0x8110);
}

TEST(ReceivedEmergency, OfBeforeTheBootIsNoFault) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.start(world.now);
  world.receive(0, canopen::make_emergency({.node = 1, .error_code = 0x5112}));
  world.cycle();
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

TEST(ReceivedEmergency, WhileDrivesAreEnabledIsAFault) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.start(world.now);
  world.cycles_to(RigState::enabling);
  world.receive(0, canopen::make_emergency({.node = 1, .error_code = 0x5112}));
  world.cycle();
  EXPECT_EQ(world.rig.faults(), RigFault::emergency);
}

/// Lets the drive fail with a code in TPDO2, after EMCYs. Returns the rig's faults at the drive.
RigFault faults_of_failed_drive(RigOnBuses& world, std::initializer_list<std::pair<int, int>> emergencies) {
  EXPECT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  for (const auto& [bus, node] : emergencies)
    world.receive(static_cast<std::size_t>(bus),
                  canopen::make_emergency({.node = static_cast<std::uint8_t>(node), .error_code = 0x2310}));
  world.drive().follows = false;
  world.drive().state = DriveState::fault;
  world.receive(world.drive().bus, cia402::make_event(world.drive().id, {.mode = 10, .error_code = 0x2310}));
  world.cycles(2);
  RigFault faults = RigFault::none;
  for (const RigFaultRecord& record : world.rig.fault_log().records())
    if (record.place.bus == world.drive().bus && record.place.node_id == world.drive().id)
      faults = faults | record.place.fault;
  return faults;
}

TEST(DriveError, IsRaisedWithItsCodeIfNoEmergencyCame) {
  RigOnBuses world(on_two_buses());
  EXPECT_EQ(faults_of_failed_drive(world, {}), RigFault::drive_error | RigFault::drive_not_enabled);
  const RigFaultPlace place = world.rig.fault_log().first(RigFault::drive_error).place;
  EXPECT_EQ(place.drive_code, 0x2310u);
  EXPECT_EQ(place.bus, 1u);
  EXPECT_EQ(place.node_id, 11);
}

TEST(DriveError, IsNotRaisedBesideTheDrivesEmergency) {
  RigOnBuses world(on_two_buses());
  EXPECT_EQ(faults_of_failed_drive(world, {{0, 1}, {1, 11}}),
            RigFault::emergency | RigFault::drive_not_enabled);
}

TEST(DriveError, IsRaisedBesideTheEmergencyOfAnotherNode) {
  RigOnBuses same_bus(on_two_buses());
  EXPECT_TRUE(any(faults_of_failed_drive(same_bus, {{1, 1}}) & RigFault::drive_error));
  RigParams params = on_two_buses();
  params.encoders[0].node_id = 11;
  RigOnBuses same_id(params);
  EXPECT_TRUE(any(faults_of_failed_drive(same_id, {{0, 11}}) & RigFault::drive_error));
}

TEST(DriveError, NeedsACodeAndAFault) {
  RigOnBuses world(row_of_hinges(1, 1));
  ASSERT_TRUE(world.boot_and_arm());
  world.receive(0, cia402::make_event(11, {.mode = 10, .error_code = 0x8611}));
  world.cycles(2);
  EXPECT_EQ(world.rig.faults(), RigFault::none) << "an enabled drive with a code of a warning";
  world.receive(0, cia402::make_event(11, {.mode = 10}));
  world.drive().follows = false;
  world.drive().state = DriveState::fault;
  world.cycles(2);
  EXPECT_EQ(world.rig.faults(), RigFault::drive_not_enabled) << "the code is not here yet";
  world.receive(0, cia402::make_event(11, {.mode = 10, .error_code = 0x2310}));
  world.cycle();
  EXPECT_EQ(world.rig.faults(), RigFault::drive_not_enabled | RigFault::drive_error);
}

TEST(DriveError, OfBeforeTheBootIsReset) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.drive().state = DriveState::fault;
  world.rig.start(0);
  for (int i = 0; i < 3; ++i) {
    world.receive(0, cia402::make_event(11, {.mode = 10, .error_code = 0x2310}));
    world.cycle();
  }
  EXPECT_EQ(world.cycles_to(RigState::fault, 100), 100) << world.rig.fault_text();
  EXPECT_EQ(world.rig.state(), RigState::ready);
}

TEST(DriveError, OfADriveWithoutCanopenHasItsCode) {
  for (const DriveProtocol protocol : {DriveProtocol::odrive, DriveProtocol::moteus}) {
    RigOnBuses world(row_of_hinges(0, 2, protocol));
    ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
    world.drive(1).drive->fail();
    world.cycles(RigOnBuses::heartbeat_cycles);
    const RigFaultRecord record = world.rig.fault_log().first(RigFault::drive_error);
    EXPECT_EQ(record.place.node_id, 12);
    const bool is_moteus = protocol == DriveProtocol::moteus;
    EXPECT_EQ(record.place.drive_code, is_moteus ? 33u : odrive::error_estop);
    EXPECT_TRUE(record.evidence.has_own_state);
    EXPECT_EQ(record.evidence.error_code, record.place.drive_code);
    EXPECT_EQ(record.evidence.own_state & 0xFFu, is_moteus ? 1u : odrive::axis_idle);
  }
}

TEST(Heartbeat, OfAnOdriveIsNotReplacedByItsAnswers) {
  RigOnBuses world(row_of_hinges(0, 2, DriveProtocol::odrive));
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  world.drive(1).sends_heartbeats = false;
  EXPECT_NEAR(world.cycles_to(RigState::fault), 500, RigOnBuses::heartbeat_cycles + 1);
  ASSERT_EQ(world.rig.faults(), RigFault::heartbeat_lost);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u);
  EXPECT_EQ(world.rig.fault_log().records()[0].place.node_id, 12);
}

TEST(Heartbeat, OfAMoteusIsItsAnswer) {
  RigOnBuses world(row_of_hinges(0, 2, DriveProtocol::moteus));
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  world.cycles(1000);
  EXPECT_EQ(world.rig.faults(), RigFault::none) << world.rig.fault_text();
  world.drive(1).answers = false;
  world.cycles(505);
  EXPECT_TRUE(any(world.rig.faults() & RigFault::heartbeat_lost));
}

TEST(Heartbeat, OfACanopenDriveIsNotReplacedByItsPdos) {
  RigOnBuses world(row_of_hinges(1, 1));
  ASSERT_TRUE(world.boot_and_arm());
  world.drive().sends_heartbeats = false;
  world.cycles_to(RigState::fault);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
  EXPECT_EQ(world.rig.fault_log().records()[0].place,
            (RigFaultPlace{.fault = RigFault::heartbeat_lost, .bus = 0, .node_id = 11}));
  EXPECT_TRUE(world.rig.fault_log().records()[0].evidence.silent);
}

TEST(Heartbeat, OfANodeThatStoppedIsAFaultOnceTheRigIsUp) {
  for (const NmtState state : {NmtState::pre_operational, NmtState::stopped, NmtState::boot_up}) {
    RigOnBuses world(row_of_hinges(1, 1));
    world.rig.start(0);
    world.receive(0, canopen::make_heartbeat(1, state));
    world.cycle();
    EXPECT_EQ(world.rig.faults(), RigFault::none) << "while booting";
    world.cycles_to(RigState::ready);
    ASSERT_TRUE(world.rig.arm());
    world.receive(0, canopen::make_heartbeat(11, state));
    world.cycle();
    ASSERT_EQ(world.rig.faults(), RigFault::node_restarted);
    const RigFaultRecord& record = world.rig.fault_log().records()[0];
    EXPECT_EQ(record.place.node_id, 11);
    EXPECT_EQ(record.evidence.nmt_state, static_cast<std::uint8_t>(state));
  }
}

TEST(Heartbeat, BootUpOfANodeIsAnsweredByAnotherStartAtOnce) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.encoder().nmt = NmtState::pre_operational;
  world.rig.start(0);
  world.cycle();
  ASSERT_EQ(world.sent(0, canopen::nmt_cob_id), 1);
  world.cycles(8);  // until the encoder's next heartbeat
  const auto starts_of_encoder = [&] {
    int count = 0;
    for (const CanFrame& frame : world.bus[0].sent) {
      canopen::Nmt nmt;
      if (canopen::parse_nmt(frame, nmt) == ParseResult::ok && nmt.node == 1) ++count;
    }
    return count;
  };
  EXPECT_EQ(starts_of_encoder(), 0) << "sent again after 250 ms only";
  world.receive(0, canopen::make_heartbeat(1, NmtState::pre_operational));
  world.cycle();
  EXPECT_EQ(starts_of_encoder(), 0);
  world.receive(0, canopen::make_heartbeat(1, NmtState::boot_up));
  world.encoder().sends_heartbeats = false;
  world.cycle();
  EXPECT_EQ(starts_of_encoder(), 1);
}

TEST(ReceivedAnswer, BeforeTheFirstSyncIsNoSample) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.start(0);
  world.receive(0, cia406::make_position(1, 7), 0);
  world.receive(0, cia402::make_status(11, {.statusword = 0x40, .position_counts = 7}), 0);
  world.rig.receive(world.now);
  EXPECT_FALSE(world.rig.encoder(0).has_sample());
  EXPECT_EQ(world.rig.encoder(0).counters().accepted, 0u);
  EXPECT_EQ(world.rig.drive_feedback(0, 0).state, MotorState::unknown);
  EXPECT_FALSE(world.rig.drive_feedback(0, 0).position.valid);
  world.cycle();
  EXPECT_EQ(world.rig.encoder(0).counters().accepted, 1u);
  EXPECT_TRUE(world.rig.encoder(0).has_sample());
  EXPECT_EQ(world.rig.drive_feedback(0, world.now).state, MotorState::off);
  EXPECT_EQ(world.rig.counters().repeated, 0u);
}

/// Each node has a delay of its own, found by SYNCs that are left out.
TEST(ReceivedAnswer, HasTheTimeOfTheSyncThatItAnswers) {
  for (const std::size_t delay : {0u, 1u, 2u}) {
    RigParams params = row_of_hinges(2, 2);
    RigOnBuses world(params);
    world.encoder(0).delay = delay;
    world.drive(1).delay = delay;
    ASSERT_TRUE(world.boot_and_arm()) << delay << world.rig.fault_text();
    world.cycles(100);
    const Nanoseconds last_sync = world.now - ms + RigOnBuses::sync_ns;
    const Nanoseconds answered = last_sync - static_cast<Nanoseconds>(delay) * ms;
    EXPECT_EQ(world.rig.encoder(0).sample(world.now).t_ns, answered) << delay;
    EXPECT_EQ(world.rig.encoder(1).sample(world.now).t_ns, last_sync);
    EXPECT_EQ(world.rig.drive_feedback(0, world.now).position.t_ns, last_sync);
    EXPECT_EQ(world.rig.drive_feedback(1, world.now).position.t_ns, answered);
    EXPECT_EQ(world.sample.t_ns, answered);
    EXPECT_EQ(world.sample.age, world.now - ms + RigOnBuses::read_ns - answered);
  }
}

// A frame that ends within SYNC's own time on the wire may have delayed it.
TEST(ReceivedAnswer, IsNotSampledAfterItsBeginning) {
  RigOnBuses world(row_of_hinges(2, 0));
  ASSERT_TRUE(world.boot_and_arm());
  world.encoder(0).answers = world.encoder(1).answers = false;
  world.begin();
  world.receive(0, cia406::make_position(1, 0), world.now + 60 * us);
  constexpr Nanoseconds latest_end = (60 + 3) * us + RigOnBuses::sync_ns;
  world.receive(0, cia406::make_position(2, 0), world.now + 160 * us);
  world.finish();
  const Nanoseconds t_ns = world.rig.encoder(1).sample(world.now).t_ns - (world.now - ms);
  EXPECT_GT(t_ns, RigOnBuses::sync_ns);
  EXPECT_LT(t_ns, latest_end) << "its own beginning";
}

// The host sends six SYNCs before it reads: the longest measurement of a delay, and one.
TEST(ReceivedAnswer, ThatIsReadLateHasTheTimeOfItsSync) {
  for (const int periods : {6, 7}) {
    RigOnBuses world(row_of_hinges(1, 0));
    ASSERT_TRUE(world.boot());
    world.encoder().answers = false;
    world.begin();
    const CanFrame answer = cia406::make_position(1, 0);
    const Nanoseconds sync_end = world.now + RigOnBuses::sync_ns, end = world.now + RigOnBuses::answer_ns;
    for (int i = 0; i < periods; ++i) world.rig.sync(world.now += ms);
    world.receive(0, answer, end);
    world.rig.receive(world.now);
    const Nanoseconds t_ns = world.rig.encoder(0).sample(world.now).t_ns;
    if (periods == 6) {
      EXPECT_EQ(t_ns, sync_end);
      continue;
    }
    EXPECT_GT(t_ns, sync_end) << "its SYNC is forgotten";
    EXPECT_LT(t_ns, end);
  }
}

/// A surplus answer puts a delay in doubt that was found. Without a delay it is a copy.
TEST(RepeatedAnswer, PutsADelayInDoubt) {
  for (const bool is_drive : {false, true})
    for (const std::size_t delay : {0u, 1u}) {
      RigOnBuses world(row_of_hinges(1, 1));
      (is_drive ? world.drive() : world.encoder()).delay = delay;
      ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
      world.cycles(100);
      ASSERT_EQ(world.rig.counters().repeated, 0u);
      world.begin();
      world.receive(0, is_drive ? cia402::make_status(11, {.statusword = 0x1627, .position_counts = 0})
                                : cia406::make_position(1, 0));
      world.finish();
      EXPECT_EQ(world.rig.counters().repeated, 1u);
      world.cycle();
      EXPECT_EQ(world.sent(0, canopen::sync_cob_id), delay == 0 ? 1 : 0)
          << "a SYNC left out measures it again";
    }
}

TEST(ReceivedInputs, AreThoseOfTheButtonsOfTheirNode) {
  RigParams params = row_of_hinges(1, 0);
  params.buttons = {{.use = ButtonUse::hold, .node_id = 3, .bit = 1},
                    {.use = ButtonUse::clutch, .node_id = 4, .bit = 1},
                    {.use = ButtonUse::hold, .node_id = 4, .bit = 2}};
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot()) << world.rig.fault_text();
  const auto press = [&](std::uint8_t node, std::uint8_t inputs) {
    world.receive(0, cia401::make_inputs(node, inputs));
    world.rig.receive(world.now);
    const DeviceButtons buttons = world.rig.read(world.now).buttons;
    return std::pair(buttons.hold, buttons.clutch);
  };
  EXPECT_EQ(press(3, 0b010), std::pair(true, false));
  EXPECT_EQ(press(4, 0b010), std::pair(true, true));
  EXPECT_EQ(press(3, 0), std::pair(false, true));
  EXPECT_EQ(press(4, 0b100), std::pair(true, false));
  EXPECT_EQ(press(4, 0b111), std::pair(true, true));
  world.button(0).sends_heartbeats = false;
  world.cycles_to(RigState::fault);
  const RigFaultRecord record = world.rig.fault_log().first(RigFault::heartbeat_lost);
  EXPECT_EQ(record.place.node_id, 3);
  EXPECT_TRUE(record.evidence.answered);
}

TEST(ReceivedInputs, OfEveryButtonNodeAreAwaited) {
  RigParams params = row_of_hinges(1, 0);
  params.boot_timeout_s = 0.1;
  params.buttons = {{.node_id = 3}, {.node_id = 4}};
  RigOnBuses world(params);
  world.button(1).answers = false;
  world.rig.start(0);
  world.cycles_to(RigState::fault);
  ASSERT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
  EXPECT_EQ(world.rig.fault_log().records()[0].place.node_id, 4);
  EXPECT_FALSE(world.rig.fault_log().records()[0].evidence.answered);
}

/// Boots a rig of one node of each kind until its time is over. `node` sends this frame only. Returns the
/// evidence of that node.
NodeEvidence evidence_at_boot_timeout(std::uint8_t node, const CanFrame& frame, bool with_heartbeats) {
  RigParams params = row_of_hinges(1, 1);
  params.boot_timeout_s = 0.1;
  params.buttons = {{.node_id = 3}};
  RigOnBuses world(params);
  for (test::ScriptedNode& one : world.nodes) {
    if (one.id != node) continue;
    one.answers = false;
    one.sends_heartbeats = with_heartbeats;
  }
  world.rig.start(0);
  for (int i = 0; i < 110; ++i) {
    world.begin();
    world.receive(0, frame);
    world.finish();
  }
  EXPECT_EQ(world.rig.faults(), RigFault::boot_timeout);
  EXPECT_EQ(world.rig.fault_log().records().size(), 1u) << world.rig.fault_text();
  const RigFaultRecord record = world.rig.fault_log().first(RigFault::boot_timeout);
  EXPECT_EQ(record.place.node_id, node);
  EXPECT_EQ(record.evidence.malformed + 9, world.rig.counters().malformed)
      << "raised after 101 of 110 frames";
  return record.evidence;
}

TEST(MalformedFrame, IsEvidenceOfItsNodeAndIsNotUsed) {
  const auto short_of = [](CanFrame frame) {
    --frame.size;
    return frame;
  };
  CanFrame long_emergency = canopen::make_emergency({.node = 1, .error_code = 0x5112});
  long_emergency.size = 12;
  CanFrame no_state = canopen::make_heartbeat(1, NmtState::operational);
  no_state.data[0] = 99;
  struct Case {
    std::uint8_t node;
    CanFrame frame;
    ParseResult why;
  };
  for (const Case& c :
       {Case{1, short_of(cia406::make_position(1, 0)), ParseResult::too_short},
        Case{11, short_of(cia402::make_status(11, {.statusword = 0x40})), ParseResult::too_short},
        Case{11, short_of(cia402::make_event(11, {})), ParseResult::too_short},
        Case{3, short_of(cia401::make_inputs(3, 0)), ParseResult::too_short},
        Case{1, long_emergency, ParseResult::too_long}}) {
    const NodeEvidence seen = evidence_at_boot_timeout(c.node, c.frame, true);
    EXPECT_EQ(seen.malformed, 101u);
    EXPECT_EQ(seen.last_malformed.identifier, c.frame.id);
    EXPECT_EQ(seen.last_malformed.size, c.frame.size);
    EXPECT_EQ(seen.last_malformed.why, c.why);
    EXPECT_TRUE(seen.heard);
    EXPECT_FALSE(seen.answered);
    EXPECT_FALSE(seen.has_own_state);
  }
  const NodeEvidence seen = evidence_at_boot_timeout(1, no_state, false);
  EXPECT_EQ(seen.malformed, 101u);
  EXPECT_EQ(seen.last_malformed.why, ParseResult::bad_value);
  EXPECT_FALSE(seen.heard);
}

TEST(MalformedFrame, OfAnEmergencyIsNoFault) {
  RigOnBuses world(row_of_hinges(1, 1));
  ASSERT_TRUE(world.boot_and_arm());
  CanFrame frame = canopen::make_emergency({.node = 1, .error_code = 0x5112});
  frame.size = 12;
  world.receive(0, frame);
  world.cycle();
  EXPECT_EQ(world.rig.faults(), RigFault::none);
  EXPECT_EQ(world.rig.counters().malformed, 1u);
}

/// A known node's frames of other services are neither samples nor malformed.
TEST(ReceivedFrame, OfAnotherServiceIsIgnored) {
  RigParams params = row_of_hinges(1, 1);
  params.buttons = {{.node_id = 3}};
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  const std::uint64_t accepted = world.rig.encoder(0).counters().accepted;
  world.rig.sync(world.now);
  for (const std::uint8_t node : std::initializer_list<std::uint8_t>{1, 3})
    world.receive(0, {.id = canopen::tpdo_cob_id(2, node), .size = 4});
  for (const std::uint8_t node : std::initializer_list<std::uint8_t>{1, 3, 11})
    for (const std::uint32_t id :
         {canopen::tpdo_cob_id(3, node), canopen::rpdo_cob_id(3, node), 0x580u + node})
      world.receive(0, {.id = id, .size = 8});
  world.rig.receive(world.now + RigOnBuses::read_ns);
  EXPECT_EQ(world.rig.encoder(0).counters().accepted, accepted);
  EXPECT_EQ(world.rig.counters().malformed, 0u);
  EXPECT_EQ(world.rig.counters().foreign, 0u);
  EXPECT_EQ(world.rig.faults(), RigFault::none);
}

TEST(ReceivedFrame, IsCountedOnEveryBusUpToTheBoundOfEach) {
  RigOnBuses world(on_two_buses());
  for (const std::size_t bus : {0u, 1u})
    for (int i = 0; i < Rig::max_frames_per_receive; ++i) world.receive(bus, {.id = 0x3E3});
  world.receive(1, {.id = 0x3E3});
  world.rig.receive(0);
  EXPECT_EQ(world.rig.counters().frames, 2u * Rig::max_frames_per_receive);
  EXPECT_EQ(world.rig.counters().receive_truncated, 2u);
  EXPECT_EQ(world.bus[0].to_receive.size(), 0u);
  EXPECT_EQ(world.bus[1].to_receive.size(), 1u);
  world.rig.receive(0);
  EXPECT_EQ(world.rig.counters().frames, 2u * Rig::max_frames_per_receive + 1);
  EXPECT_EQ(world.rig.counters().foreign, world.rig.counters().frames);
  EXPECT_EQ(world.rig.counters().receive_truncated, 2u);
}

TEST(SecondHost, OfCanopenIsOneThatSendsSyncOrCommands) {
  const auto place_after = [](const CanFrame& frame) {
    RigOnBuses world(on_two_buses());
    EXPECT_TRUE(world.boot_and_arm());
    world.receive(1, frame);
    world.cycle();
    EXPECT_EQ(world.rig.counters().foreign, world.rig.faults() == RigFault::none ? 0u : 1u);
    return world.rig.fault_log().first(RigFault::second_host);
  };
  for (const CanFrame& frame : {canopen::make_sync(), canopen::make_nmt(canopen::NmtCommand::stop, 1),
                                canopen::make_heartbeat(127, NmtState::operational)}) {
    const RigFaultRecord record = place_after(frame);
    EXPECT_EQ(record.place, (RigFaultPlace{.fault = RigFault::second_host, .bus = 1}));
    EXPECT_EQ(record.identifier, frame.id);
  }
  const CanFrame command = cia402::make_command(11, {});
  EXPECT_EQ(place_after(command).place,
            (RigFaultPlace{.fault = RigFault::second_host, .bus = 1, .node_id = 11}));
  EXPECT_EQ(place_after(command).identifier, command.id);
  EXPECT_EQ(place_after(cia402::make_command(1, {})).place.fault, RigFault::none) << "to an encoder";
}

TEST(SecondHost, OfAnotherProtocolIsOneThatCommandsADrive) {
  RigOnBuses odrives(row_of_hinges(0, 2, DriveProtocol::odrive));
  ASSERT_TRUE(odrives.boot_and_arm());
  odrives.receive(0, {.id = canopen::sync_cob_id});  // node 4's Get_Version
  odrives.receive(0, odrive::make_input_torque(13, 0));
  odrives.cycle();
  EXPECT_EQ(odrives.rig.faults(), RigFault::none) << "no drive of this rig";
  odrives.receive(0, odrive::make_input_torque(12, 0));
  odrives.cycle();
  EXPECT_EQ(odrives.rig.fault_log().first(RigFault::second_host).place.node_id, 12);
  RigOnBuses moteus(row_of_hinges(0, 2, DriveProtocol::moteus));
  ASSERT_TRUE(moteus.boot_and_arm());
  moteus.receive(0, moteus::make_query(13));
  moteus.cycle();
  EXPECT_EQ(moteus.rig.faults(), RigFault::none);
  moteus.receive(0, moteus::make_query(12));
  moteus.cycle();
  EXPECT_EQ(moteus.rig.fault_log().first(RigFault::second_host).place.node_id, 12);
}

}  // namespace
}  // namespace godobject::test_receive
