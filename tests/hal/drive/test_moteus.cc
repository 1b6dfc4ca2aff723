// moteus sub-frames: the example of its documentation, the frames of the rig, and random bytes.
#include "hal/drive/moteus.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "hal/can/timing.h"

namespace godobject::test_moteus {
namespace {

constexpr std::uint8_t node = 1;

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

CanFrame reply_frame(const std::vector<std::uint8_t>& bytes) {
  CanFrame frame{.id = moteus::reply_id(node), .fd = true, .bit_rate_switch = true, .size = 64};
  frame.data.fill(0x50);
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

TEST(Moteus, CommandOfTheDocumentation) {
  const auto bytes = bytes_of("01000a07206000200150ff140400130d");
  moteus::SubframeReader reader(bytes);
  moteus::Subframe s;
  ASSERT_TRUE(reader.next(s));
  EXPECT_EQ(s.kind, moteus::SubframeKind::write);
  EXPECT_EQ(s.first, moteus::mode);
  EXPECT_EQ(s.value(0), 10);
  ASSERT_TRUE(reader.next(s));
  EXPECT_EQ(s.type, moteus::ValueType::int16);
  EXPECT_EQ(s.first, moteus::command_position);
  ASSERT_EQ(s.count, 3u);
  EXPECT_DOUBLE_EQ(s.value(0), 0.0096);  // rev
  EXPECT_DOUBLE_EQ(s.value(1), 0.072);   // rev/s
  EXPECT_DOUBLE_EQ(s.value(2), -1.76);   // N m
  ASSERT_TRUE(reader.next(s));
  EXPECT_EQ(s.kind, moteus::SubframeKind::read);
  EXPECT_EQ(s.first, 0u);
  EXPECT_EQ(s.count, 4u);
  ASSERT_TRUE(reader.next(s));
  EXPECT_EQ(s.first, moteus::voltage);
  EXPECT_EQ(s.count, 3u);
  EXPECT_FALSE(reader.next(s));
  EXPECT_TRUE(reader.ok());
}

TEST(Moteus, FramesAreDescribedInWords) {
  const DriveText reply = moteus::describe(moteus::make_reply(node, {.mode = moteus::mode_position,
                                                                     .position_rev = -0.25,
                                                                     .velocity_rev_per_s = 0,
                                                                     .torque_Nm = 0.5,
                                                                     .fault = 97}));
  EXPECT_EQ(reply.node, node);
  EXPECT_EQ(reply.name, "reply");
  EXPECT_EQ(reply.position_counts, -25000);
  EXPECT_EQ(reply.value, "position mode, torque +0.5000 Nm, fault 97");
  const DriveText command = moteus::describe(moteus::make_torque(node, -0.25f, 0.02f));
  EXPECT_EQ(command.node, node);
  EXPECT_EQ(command.name, "command and query");
  EXPECT_EQ(command.value, "position mode, torque -0.2500 Nm");
  EXPECT_EQ(moteus::describe(moteus::make_stop(node, false)).name, "command");
  EXPECT_EQ(moteus::describe(moteus::make_stop(node, false)).value, "stopped");
  EXPECT_EQ(moteus::describe(moteus::make_query(node)).name, "query");
  CanFrame foreign = moteus::make_query(node);
  foreign.id = 0x12345;
  EXPECT_EQ(moteus::describe(foreign).node, 0);
  foreign = moteus::make_query(node);
  foreign.fd = false;
  EXPECT_EQ(moteus::describe(foreign).node, 0);
}

TEST(Moteus, ReplyOfTheDocumentation) {
  moteus::Reply reply;
  ASSERT_EQ(moteus::parse_reply(reply_frame(bytes_of("2404000a005000000170ff230d181400")), node, reply),
            ParseResult::ok);
  EXPECT_EQ(reply.mode, moteus::mode_position);
  EXPECT_DOUBLE_EQ(reply.position_rev, 0.008);
  EXPECT_DOUBLE_EQ(reply.velocity_rev_per_s, 0.064);
  EXPECT_DOUBLE_EQ(reply.torque_Nm, -1.44);
  EXPECT_EQ(reply.fault, 0);
}

TEST(Moteus, TheMostNegativeIntegerIsNoNumber) {
  moteus::Reply reply{.mode = 7};
  for (const char* hex : {"2404000a0000800001700000", "2404000a000000008070ff00", "2404000a00000000000080"})
    EXPECT_EQ(moteus::parse_reply(reply_frame(bytes_of(hex)), node, reply), ParseResult::bad_value) << hex;
  EXPECT_EQ(moteus::parse_reply(reply_frame(bytes_of("22000a00")), node, reply), ParseResult::bad_value);
  EXPECT_EQ(reply.mode, 7);
}

TEST(Moteus, ReplyThereAndBack) {
  const moteus::Reply sent{
      .mode = 10, .position_rev = -1.23456, .velocity_rev_per_s = 3.5, .torque_Nm = 0.125, .fault = 99};
  const CanFrame frame = moteus::make_reply(node, sent);
  EXPECT_EQ(frame.size, 24);
  EXPECT_TRUE(is_valid(frame));
  moteus::Reply got;
  ASSERT_EQ(moteus::parse_reply(frame, node, got), ParseResult::ok);
  EXPECT_EQ(got.mode, 10);
  EXPECT_DOUBLE_EQ(got.position_rev, -1.23456);
  EXPECT_DOUBLE_EQ(got.velocity_rev_per_s, 3.5);
  EXPECT_DOUBLE_EQ(got.torque_Nm, 0.125);
  EXPECT_EQ(got.fault, 99);
  EXPECT_EQ(moteus::parse_reply(frame, 2, got), ParseResult::other_message);
}

TEST(Moteus, TorqueCommandAndReplyHaveTheHandbooksWireTime) {
  const BitRates rates{.nominal = 1e6, .data = 5e6};
  const CanFrame command = moteus::make_torque(node, 0.1f, 0.02f);
  EXPECT_EQ(command.id, 0x8001u);
  EXPECT_TRUE(command.extended && command.fd && command.bit_rate_switch && is_valid(command));
  ASSERT_EQ(command.size, 24);
  const CanFrame reply = moteus::make_reply(node, {});
  EXPECT_EQ(reply.id, 0x100u);
  EXPECT_FALSE(reply.extended);
  const auto both = [&](auto bits) {
    return duration_ns(bits(command), rates) + duration_ns(bits(reply), rates);
  };
  EXPECT_NEAR(1e-3 * static_cast<double>(both(nominal_bits)), 171, 1);  // us
  EXPECT_NEAR(1e-3 * static_cast<double>(both(worst_bits)), 202, 1);
}

TEST(Moteus, TorqueCommandSetsTheGainsToZero) {
  const CanFrame frame = moteus::make_torque(node, -0.25f, 0.02f);
  std::vector<std::pair<std::uint32_t, double>> writes;
  moteus::SubframeReader reader(frame.bytes());
  for (moteus::Subframe s; reader.next(s);)
    for (std::uint32_t i = 0; s.kind == moteus::SubframeKind::write && i < s.count; ++i)
      writes.emplace_back(s.first + i, s.value(i));
  EXPECT_TRUE(reader.ok());
  const std::vector<std::pair<std::uint32_t, double>> expected{{moteus::mode, 10},
                                                               {moteus::feedforward_torque, -0.25},
                                                               {moteus::kp_scale, 0},
                                                               {moteus::kd_scale, 0},
                                                               {moteus::watchdog_timeout, double{0.02f}}};
  EXPECT_EQ(writes, expected);
}

TEST(Moteus, AnyBytesAreSurvived) {
  std::mt19937 random(1);
  for (int k = 0; k < 100000; ++k) {
    CanFrame frame{.id = moteus::reply_id(node), .fd = true};
    frame.size = static_cast<std::uint8_t>(random() % 65);
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    if (k % 2 == 0) frame.data[0] = static_cast<std::uint8_t>(0x20 + random() % 16);
    moteus::Reply reply;
    static_cast<void>(moteus::parse_reply(frame, node, reply));
    EXPECT_TRUE(std::isfinite(reply.position_rev) && std::isfinite(reply.torque_Nm));
  }
}

class MoteusLinkTest : public testing::Test {
 protected:
  void reply(int mode, int fault = 0) {
    const moteus::Reply r{.mode = mode, .position_rev = 0.5, .fault = fault};
    const DriveMessage message = link.decode(moteus::make_reply(node, r), telemetry);
    EXPECT_TRUE(message.result == ParseResult::ok && message.position && message.alive);
  }
  bool is(const std::optional<CanFrame>& a, const CanFrame& b) {
    return a && a->id == b.id && a->data == b.data;
  }

  DriveParams params{.joint = "j", .node_id = node};
  MoteusLink link{params, 1e-3};
  DriveTelemetry telemetry;
  const CanFrame query = moteus::make_query(node), stop = moteus::make_stop(node, true);
};

TEST_F(MoteusLinkTest, OnlyQueriesUntilItIsToBeEnabled) {
  EXPECT_TRUE(is(link.request({.goal = DriveGoal::enable}), query));
  reply(moteus::mode_stopped);
  EXPECT_EQ(telemetry.state, MotorState::off);
  EXPECT_EQ(telemetry.position_counts, 50000u);
  EXPECT_TRUE(is(link.request({.goal = DriveGoal::hold}), query));
  EXPECT_TRUE(is(link.request({.goal = DriveGoal::enable}), moteus::make_torque(node, 0, 0.02f)));
  reply(moteus::mode_position);
  EXPECT_EQ(telemetry.state, MotorState::enabled);
  EXPECT_TRUE(
      is(link.request({.goal = DriveGoal::hold, .torque_Nm = 0.5}), moteus::make_torque(node, 0.5f, 0.02f)));
  EXPECT_FALSE(link.command({.goal = DriveGoal::hold, .torque_Nm = 0.5}, 0).frame);
}

// After its power was cycled a drive is stopped, and a torque command would enable it.
TEST_F(MoteusLinkTest, SilentDriveReceivesNoTorqueCommandUntilItAnswers) {
  const CanFrame torque = moteus::make_torque(node, 0.5f, 0.02f);
  const DriveOrder hold{.goal = DriveGoal::hold, .torque_Nm = 0.5};
  reply(moteus::mode_position);
  for (int i = 0; i <= 20; ++i) {  // 20 ms, its watchdog
    EXPECT_TRUE(is(link.request(hold), torque)) << i;
    link.sent({}, 0);
  }
  EXPECT_TRUE(is(link.request(hold), query));
  EXPECT_TRUE(is(link.request({.goal = DriveGoal::off}), stop));
  reply(moteus::mode_position);  // its answers alone were lost
  EXPECT_TRUE(is(link.request(hold), torque));
}

TEST_F(MoteusLinkTest, LatchedModesAreLeftByAStop) {
  for (const int mode : {moteus::mode_fault, moteus::mode_timeout}) {
    reply(mode, mode == moteus::mode_fault ? 33 : 0);
    EXPECT_EQ(telemetry.state, MotorState::fault);
    EXPECT_EQ(telemetry.error_code, mode == moteus::mode_fault ? 33u : 0u);
    EXPECT_TRUE(is(link.request({.goal = DriveGoal::hold}), query));
    EXPECT_TRUE(is(link.request({.goal = DriveGoal::enable}), stop));
  }
}

TEST_F(MoteusLinkTest, LimitsAreNoFault) {
  reply(moteus::mode_position, 97);
  EXPECT_TRUE(telemetry.internal_limit);
  EXPECT_EQ(telemetry.error_code, 0u);
}

TEST_F(MoteusLinkTest, AStopDoesNotWaitForTheNextCycle) {
  reply(moteus::mode_position);
  EXPECT_TRUE(is(link.command({.goal = DriveGoal::quick_stop}, 0).frame, moteus::make_stop(node, false)));
  EXPECT_TRUE(is(link.request({.goal = DriveGoal::quick_stop}), stop));
  EXPECT_TRUE(is(link.command({.goal = DriveGoal::off}, 0).frame, moteus::make_stop(node, false)));
}

}  // namespace
}  // namespace godobject::test_moteus
