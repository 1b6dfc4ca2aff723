// An encoder board as the nodes of a rig.
#include "hal/board/nodes.h"

#include <gtest/gtest.h>

#include <vector>

#include "hal/canopen/cia406.h"

namespace godobject::test_board_nodes {
namespace {

constexpr Nanoseconds ms = 1'000'000;

/// A board at 1 kHz with two channels: one at rest, one at constant speed. Its clock is that of the host.
class BoardNodesTest : public testing::Test {
 protected:
  void frame() {
    const auto t_us = static_cast<std::uint32_t>(now_ / 1000);
    EncoderFrame frame{.sequence = sequence_++, .t_us = t_us - clock_origin_us_, .num_counts = 2};
    frame.counts[0] = -7;
    frame.counts[1] =
        static_cast<std::int32_t>(0x7FFF'FFF0u + t_us / 100);  // 10 counts a frame, across the wrap
    std::array<std::uint8_t, max_encoder_wire> wire{};
    nodes_.receive(make_encoder_frame(frame, wire), now_);
  }
  /// Runs milliseconds with a frame at the start of each; returns the frames of the nodes.
  std::vector<ReceivedFrame> run(int num = 1, bool with_frames = true) {
    std::vector<ReceivedFrame> got;
    for (const Nanoseconds end = now_ + num * ms; now_ < end;) {
      if (with_frames) frame();
      for (const Nanoseconds next = now_ + ms; now_ < next; now_ += 10'000) receive(got);
    }
    return got;
  }
  void receive(std::vector<ReceivedFrame>& got) {
    for (ReceivedFrame received; nodes_.try_receive(received, now_);) {
      EXPECT_LE(received.t_ns, now_);
      got.push_back(received);
    }
  }
  static int count(const std::vector<ReceivedFrame>& got, std::uint32_t id) {
    return static_cast<int>(
        std::ranges::count_if(got, [id](const ReceivedFrame& r) { return r.frame.id == id; }));
  }
  static canopen::NmtState state_in(const std::vector<ReceivedFrame>& got, std::uint8_t node) {
    canopen::Heartbeat heartbeat;
    for (const ReceivedFrame& received : got)
      if (received.frame.id == canopen::heartbeat_cob_id(node)) {
        EXPECT_EQ(canopen::parse_heartbeat(received.frame, heartbeat), ParseResult::ok);
      }
    return heartbeat.state;
  }

  Nanoseconds now_ = 10'000 * ms;
  std::uint32_t clock_origin_us_ = 0;
  std::uint8_t sequence_ = 0;
  BoardNodes nodes_{1e6};
};

TEST_F(BoardNodesTest, ChannelsBootAndAreStarted) {
  std::vector<ReceivedFrame> got = run(0);
  receive(got);
  EXPECT_TRUE(got.empty()) << "there is no board yet";
  got = run(1);
  ASSERT_GE(got.size(), 2u);
  EXPECT_EQ(got[0].frame.id, canopen::heartbeat_cob_id(1));
  EXPECT_EQ(got[0].frame.data[0], 0) << "boot-up";
  EXPECT_EQ(state_in(got, 2), canopen::NmtState::pre_operational);
  nodes_.send(canopen::make_sync(), now_);
  EXPECT_EQ(count(run(1), canopen::tpdo_cob_id(1, 1)), 0) << "no PDOs before Operational";
  nodes_.send(canopen::make_nmt(canopen::NmtCommand::start, 2), now_);
  got = run(1);
  EXPECT_EQ(state_in(got, 1), canopen::NmtState::pre_operational);
  EXPECT_EQ(state_in(got, 2), canopen::NmtState::operational);
  EXPECT_EQ(count(run(1000), canopen::heartbeat_cob_id(2)), 10);
}

TEST_F(BoardNodesTest, SyncIsAnsweredWithTheCountsAtItsEnd) {
  run(3);
  nodes_.send(canopen::make_nmt(canopen::NmtCommand::start, 0), now_);
  run(3);
  now_ += ms / 2;  // a frame and a half after the newest counts
  nodes_.send(canopen::make_sync(), now_);
  const Nanoseconds t_sync = now_;
  ASSERT_TRUE(nodes_.next_due().has_value());
  EXPECT_GT(*nodes_.next_due(), t_sync + 100'000) << "SYNC and the answer take their time on the wire";
  std::vector<ReceivedFrame> got;
  for (; now_ < t_sync + ms / 2; now_ += 1000) receive(got);
  std::vector<std::uint32_t> positions;
  for (const ReceivedFrame& received : got)
    for (std::uint8_t node = 1; node <= 2; ++node) {
      std::uint32_t counts = 0;
      if (cia406::parse_position(received.frame, node, counts) == ParseResult::ok)
        positions.push_back(counts);
    }
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[0], static_cast<std::uint32_t>(-7));
  const auto t_us = static_cast<std::uint32_t>(t_sync / 1000);
  EXPECT_NEAR(static_cast<double>(positions[1]), 0x7FFF'FFF0u + (t_us + 44) / 100.0, 1);
}

TEST_F(BoardNodesTest, SilentWhenTheBoardIs) {
  run(3);
  nodes_.send(canopen::make_nmt(canopen::NmtCommand::start, 0), now_);
  run(3);
  std::vector<ReceivedFrame> got = run(3, false);
  nodes_.send(canopen::make_sync(), now_);
  EXPECT_EQ(count(run(1, false), canopen::tpdo_cob_id(1, 1)), 1) << "a few frames may be missing";
  EXPECT_TRUE(run(500, false).empty());
  EXPECT_TRUE(nodes_.silent(now_));
  nodes_.send(canopen::make_sync(), now_);
  EXPECT_TRUE(run(500, false).empty());
  EXPECT_FALSE(nodes_.next_due().has_value());
  run(2);
  nodes_.send(canopen::make_sync(), now_);
  EXPECT_EQ(count(run(1), canopen::tpdo_cob_id(1, 1)), 1) << "still operational";
}

/// Its counts start again, so the rig must be informed.
TEST_F(BoardNodesTest, ABoardThatRebootsIsANodeThatReboots) {
  run(3);
  nodes_.send(canopen::make_nmt(canopen::NmtCommand::start, 0), now_);
  run(3);
  clock_origin_us_ = static_cast<std::uint32_t>(now_ / 1000);
  const std::vector<ReceivedFrame> got = run(2);
  ASSERT_GE(got.size(), 2u);
  EXPECT_EQ(got[0].frame.id, canopen::heartbeat_cob_id(1));
  EXPECT_EQ(got[0].frame.data[0], 0);
  nodes_.send(canopen::make_sync(), now_);
  EXPECT_EQ(count(run(1), canopen::tpdo_cob_id(1, 1)), 0);
}

TEST_F(BoardNodesTest, WhatFindsNoRoomIsCounted) {
  run(3);
  nodes_.send(canopen::make_nmt(canopen::NmtCommand::start, 0), now_);
  for (int i = 0; i < 200; ++i) nodes_.send(canopen::make_sync(), now_);
  EXPECT_GT(nodes_.num_lost(), 0u);
  EXPECT_GT(count(run(1), canopen::tpdo_cob_id(1, 2)), 10);
}

}  // namespace
}  // namespace godobject::test_board_nodes
