#include "sim/node/encoder_board.h"

#include <gtest/gtest.h>

namespace godobject::test_sim_encoder_board {
namespace {

/// The board and the host's end, in steps of 0.1 ms.
struct BoardRig {
  void run(double s) {
    for (const Nanoseconds end = now + static_cast<Nanoseconds>(1e9 * s); now < end; now += 100'000) {
      std::array<std::uint8_t, max_encoder_wire> bytes{};
      static_cast<void>(host.receive(board.transmit(bytes, now), now));
    }
  }

  SimEncoderBoard board{1000, 3, 1};
  EncoderBoard host;
  Nanoseconds now = 0;
};

TEST(SimEncoderBoard, CountsArrive) {
  BoardRig rig;
  rig.board.set_count(2, -123456);
  rig.run(1);
  EXPECT_EQ(rig.host.counters().frames, 1000u);
  EXPECT_EQ(rig.host.counters().lost, 0u);
  EXPECT_EQ(rig.host.frame().num_counts, 3u);
  EXPECT_EQ(rig.host.frame().counts[2], -123456);
}

TEST(SimEncoderBoard, EveryFaultIsCounted) {
  BoardRig rig;
  rig.board.faults.drop_probability = 0.01;
  rig.run(10);
  const std::uint64_t lost = rig.host.counters().lost;
  EXPECT_EQ(rig.host.counters().frames + lost, 10'000u);
  EXPECT_NEAR(static_cast<double>(lost), 100, 40);
  rig.board.faults = {.corrupt_probability = 0.01};
  rig.run(10);
  EXPECT_GT(rig.host.counters().bad_crc + rig.host.counters().malformed, 50u);
  rig.board.faults = {.silent = true};
  rig.run(2);
  rig.board.faults = {};
  rig.board.reboot();
  rig.run(1);
  EXPECT_EQ(rig.host.counters().reboots, 1u);
}

TEST(SimEncoderBoard, DriftOfItsClockIsFollowed) {
  BoardRig rig;
  rig.board.faults.clock_drift = 100;
  rig.run(20);
  EXPECT_NEAR(rig.host.clock().drift_ppm(), -100, 10);
  EXPECT_LT(rig.now - rig.host.t_ns(), 1'200'000);
}

}  // namespace
}  // namespace godobject::test_sim_encoder_board
