// Beginning of a rig's cycles: SYNC and requests, SYNCs that are left out, the host's heartbeat, and counts.
#include <gtest/gtest.h>

#include <vector>

#include "hal/can/timing.h"
#include "tests/support/rig_on_buses.h"

namespace godobject::test_request {
namespace {

using test::RigOnBuses;
using test::row_of_hinges;
using test::row_on_two_buses;
using test::texts_of;

constexpr std::uint32_t host_heartbeat = canopen::heartbeat_cob_id(127);
constexpr std::size_t beyond_reach = 6;  // cycles of delay, of a stale_after of 3

/// Runs cycles. Returns the numbers of those without SYNC on a bus, from 1.
std::vector<int> cycles_without_sync(RigOnBuses& world, int count, std::size_t bus = 0) {
  std::vector<int> out;
  for (int i = 0; i < count; ++i) {
    world.cycle();
    if (world.sent(bus, canopen::sync_cob_id) == 0) out.push_back(world.num_cycles);
  }
  return out;
}

TEST(HostHeartbeat, IsSentToEveryCanopenBusAtItsPeriod) {
  RigParams params = row_on_two_buses(1, DriveProtocol::odrive, 3);
  params.heartbeat_period_s = 0.05;
  RigOnBuses world(params);
  world.bus[0].live = world.bus[1].live = false;  // without SYNCs left out
  world.rig.start(0);
  for (int i = 0; i < 160; ++i) {
    world.cycle();
    for (const std::size_t bus : {0u, 1u}) {
      ASSERT_EQ(world.sent(bus, host_heartbeat), i % 50 == 0 ? 1 : 0) << i;
      EXPECT_EQ(world.sent(bus, canopen::sync_cob_id), 1);
    }
    EXPECT_EQ(world.sent(2, host_heartbeat), 0) << "no bus of CANopen";
  }
}

TEST(HostHeartbeat, IsSentAtOnceAfterAnotherStart) {
  RigOnBuses world(row_of_hinges(1, 0));
  world.rig.start(0);
  world.cycles(10);
  world.rig.stop();
  world.rig.start(world.now);
  world.cycle();
  EXPECT_EQ(world.sent(0, host_heartbeat), 1);
}

TEST(SyncLeftOut, IsOneAfterTwoAnswersWithTheHeartbeatInItsPlace) {
  RigOnBuses world(row_of_hinges(1, 1));
  world.rig.start(0);
  world.cycles(2);
  EXPECT_EQ(world.sent(0, host_heartbeat), 0);
  EXPECT_EQ(cycles_without_sync(world, 1), std::vector{3});
  EXPECT_EQ(world.sent(0, host_heartbeat), 1);
  EXPECT_EQ(cycles_without_sync(world, 200), std::vector<int>{});
}

TEST(SyncLeftOut, FollowsASecondTimeToConfirmADelay) {
  RigOnBuses world(row_of_hinges(1, 0));
  world.encoder().delay = 1;
  world.rig.start(0);
  EXPECT_EQ(cycles_without_sync(world, 200), (std::vector{4, 4 + 17}));
}

/// Distances grow by the longest measurement, because a delay of one distance would appear as none.
TEST(SyncLeftOut, ComesMoreRarelyTheLongerADelayIsInDoubt) {
  for (const std::size_t late : {0u, 1u}) {
    RigOnBuses world(row_of_hinges(2, 0));
    world.encoder(late).delay = beyond_reach;
    world.rig.start(0);
    const std::vector<int> left_out = cycles_without_sync(world, 150);
    EXPECT_EQ(left_out, (std::vector{3, 20, 20 + 17, 37 + 22, 59 + 27, 86 + 32}))
        << "in cycle 3 of the other";
  }
}

/// A drive that answers every 20th SYNC takes 43 to show one that was left out, on its own bus only.
TEST(SyncLeftOut, AwaitsTheLongestMeasurementOfItsBus) {
  RigParams params = row_on_two_buses(1);
  params.drives[0].status_every_nth_sync = 20;
  RigOnBuses world(params);
  for (test::ScriptedNode& node : world.nodes) node.delay = beyond_reach;
  world.drive().answers = false;
  world.rig.start(0);
  std::vector<int> first, second;
  for (int i = 0; i < 100; ++i) {
    world.cycle();
    if (world.sent(0, canopen::sync_cob_id) == 0) first.push_back(world.num_cycles);
    if (world.sent(1, canopen::sync_cob_id) == 0) second.push_back(world.num_cycles);
  }
  EXPECT_EQ(first, (std::vector{9, 26, 48, 75}));
  EXPECT_EQ(second, (std::vector{9, 26, 26 + 17 + 43}));
}

TEST(SyncLeftOut, AwaitsTheAnswerOfASlowDriveToTheLastOne) {
  RigParams params = row_of_hinges(1, 1);
  params.drives[0].status_every_nth_sync = 20;
  RigOnBuses world(params);
  world.rig.start(0);
  EXPECT_EQ(cycles_without_sync(world, 42), (std::vector{3, 42})) << "the drive answers in cycles 21 and 41";
  world.drive().answers = false;
  world.cycles(2);
  world.encoder().answers = false;
  world.cycle();
  world.encoder().answers = true;
  EXPECT_EQ(cycles_without_sync(world, 50), std::vector{42 + 1 + 43});
}

TEST(SyncLeftOut, IsThatOfTheBusInDoubt) {
  RigOnBuses world(row_on_two_buses(0));
  world.bus[1].live = false;
  ASSERT_TRUE(world.boot());
  world.cycles(20);
  const auto lose_an_answer = [&](std::size_t encoder) {
    world.encoder(encoder).answers = false;
    world.cycle();
    world.encoder(encoder).answers = true;
    world.cycles(1);
    world.cycle();
  };
  lose_an_answer(1);
  EXPECT_EQ(world.sent(0, canopen::sync_cob_id), 1);
  EXPECT_EQ(world.sent(1, canopen::sync_cob_id), 1) << "a log";
  lose_an_answer(0);
  EXPECT_EQ(world.sent(0, canopen::sync_cob_id), 0);
  EXPECT_EQ(world.sent(1, canopen::sync_cob_id), 1);
}

TEST(SyncLeftOut, IsNoneOfABusWhoseNodesSendByThemselves) {
  RigOnBuses world(row_of_hinges(0, 1, DriveProtocol::odrive));
  world.rig.start(0);
  for (int i = 0; i < 100; ++i) {
    world.cycle();
    ASSERT_EQ(world.sent(0, odrive::frame_id(11, odrive::Command::encoder_estimates)), 1) << i;
  }
  EXPECT_EQ(world.rig.state(), RigState::ready) << "its delay is not awaited";
}

TEST(SyncCount, IsOfCyclesWithOneOnAnyBus) {
  RigOnBuses world(row_on_two_buses(0));
  ASSERT_TRUE(world.boot());
  const std::uint64_t before = world.rig.counters().syncs;
  const auto syncs_with = [&](bool first_full, bool second_full) {
    world.bus[0].full = first_full;
    world.bus[1].full = second_full;
    world.cycle();
    return world.rig.counters().syncs - before;
  };
  EXPECT_EQ(syncs_with(false, false), 1u);
  EXPECT_EQ(syncs_with(true, false), 2u);
  EXPECT_EQ(syncs_with(false, true), 3u);
  EXPECT_EQ(syncs_with(true, true), 3u);
}

TEST(SyncCount, OfIncompleteOnesIsOfARunningRig) {
  RigOnBuses world(row_on_two_buses(0));
  world.rig.start(0);
  const auto lose_an_answer = [&] {
    world.encoder().answers = false;
    world.cycle();
    world.encoder().answers = true;
  };
  lose_an_answer();
  world.cycles_to(RigState::ready);
  world.cycles(20);
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 0u) << "while booting";
  lose_an_answer();
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 0u) << "the answer may still come";
  world.bus[0].full = world.bus[1].full = true;
  world.cycle();
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 0u) << "no SYNC was queued after it";
  world.bus[0].full = world.bus[1].full = false;
  world.cycle();
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 1u);
  EXPECT_FALSE(cycles_without_sync(world, 5).empty()) << "to measure the delay again";
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 1u) << "a SYNC that was left out has no answer";
  world.rig.quick_stop();
  lose_an_answer();
  world.cycles(3);
  EXPECT_EQ(world.rig.counters().incomplete_syncs, 1u) << "after a fault";
}

TEST(Complete, AwaitsEveryNode) {
  RigOnBuses world(row_of_hinges(2, 2));
  ASSERT_TRUE(world.boot());
  for (std::size_t missing = 0; missing <= 4; ++missing) {
    world.cycles(50);
    if (missing < 4) world.nodes[missing].answers = false;
    world.cycle();
    EXPECT_EQ(world.rig.complete(), missing == 4) << missing;
    if (missing < 4) world.nodes[missing].answers = true;
  }
}

/// Returns the time on the wire of a frame without stuffing of its data, ns.
Nanoseconds wire_ns(const CanFrame& frame) {
  FrameBits bits = exact_bits(frame);
  bits.nominal_rate -= intermission_bits;
  return duration_ns(bits, {.nominal = 1e6, .data = 1e6});
}

TEST(Request, IsSentToTheDrivesOfItsBusAndStandsForSync) {
  RigParams params = row_of_hinges(0, 3, DriveProtocol::odrive, 2);
  params.drives[0].bus = 0;
  RigOnBuses world(params);
  ASSERT_TRUE(world.boot());
  const std::uint64_t syncs = world.rig.counters().syncs;
  world.begin();
  const CanFrame first = odrive::make_request(11, odrive::Command::encoder_estimates);
  const CanFrame second = odrive::make_request(12, odrive::Command::encoder_estimates);
  const CanFrame third = odrive::make_request(13, odrive::Command::encoder_estimates);
  EXPECT_EQ(texts_of(world.bus[0].sent), texts_of({first}));
  EXPECT_EQ(texts_of(world.bus[1].sent), texts_of({second, third}));
  EXPECT_EQ(world.rig.counters().syncs, syncs + 1);
  const Nanoseconds began = world.now;
  world.finish();
  EXPECT_TRUE(world.rig.complete());
  EXPECT_EQ(world.rig.drive_feedback(0, world.now).position.t_ns, began + wire_ns(first));
  EXPECT_EQ(world.rig.drive_feedback(1, world.now).position.t_ns, began + wire_ns(second));
  EXPECT_EQ(world.rig.drive_feedback(2, world.now).position.t_ns, began + wire_ns(second))
      << "the first request";
  world.bus[0].full = world.bus[1].full = true;
  world.rig.sync(world.now);
  EXPECT_EQ(world.rig.counters().syncs, syncs + 1) << "none was queued";
}

TEST(Request, OfAMoteusThatIsRefusedSendsNoTorque) {
  RigOnBuses world(row_of_hinges(0, 2, DriveProtocol::moteus));
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  world.F[0].f = Vec3(0, 0.5, 0);  // 0.05 N m about both hinges
  world.cycle();
  EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0) << "the next request carries it";
  world.bus[0].refused_id = moteus::request_id(12);
  world.cycle();
  EXPECT_EQ(world.report.not_sent, 0b10u);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(0), 0.05, 1e-12);
  EXPECT_NEAR(world.drive(0).drive->torque_Nm, 0.05, 1e-6);
  EXPECT_EQ(world.rig.commanded_torque_Nm(1), 0);
  EXPECT_EQ(world.drive(1).drive->torque_Nm, 0);
  world.bus[0].refused_id.reset();
  world.cycle();
  EXPECT_EQ(world.report.not_sent, 0u);
  EXPECT_NEAR(world.rig.commanded_torque_Nm(1), 0.05, 1e-12);
}

/// The order of before would be a torque, after the emergency stop.
TEST(Request, OfAMoteusAfterARefusedStopIsTheStop) {
  RigOnBuses world(row_of_hinges(0, 1, DriveProtocol::moteus));
  ASSERT_TRUE(world.boot_and_arm()) << world.rig.fault_text();
  world.F[0].f = Vec3(0, 0.5, 0);
  world.cycles(2);
  ASSERT_NE(world.drive().drive->torque_Nm, 0);
  world.bus[0].full = true;
  world.rig.quick_stop();
  world.cycle();
  EXPECT_EQ(world.rig.torque_output(), TorqueOutput::at_once);
  world.bus[0].full = false;
  world.begin();
  ASSERT_EQ(world.bus[0].sent.size(), 1u);
  EXPECT_EQ(moteus::describe(world.bus[0].sent[0]).value, "stopped");
  EXPECT_EQ(world.drive().drive->torque_Nm, 0);
}

}  // namespace
}  // namespace godobject::test_request
