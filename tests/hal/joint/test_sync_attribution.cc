// Scripted receive stamps at 1 Mbit/s: 1 us per bit.
#include "hal/joint/sync_attribution.h"

#include <gtest/gtest.h>

#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"

namespace godobject::test_sync_attribution {
namespace {

constexpr Nanoseconds us = 1000;
constexpr Nanoseconds ms = 1'000'000;

Nanoseconds wire_time(const CanFrame& frame) { return (exact_bits(frame).total() - intermission_bits) * us; }

const Nanoseconds sync_ns = wire_time(canopen::make_sync());

class SyncAttributionTest : public testing::Test {
 protected:
  SyncAttribution::Answer frame_from(Nanoseconds start_ns,
                                     const CanFrame& frame = cia406::make_position(1, 5)) {
    return syncs.on_frame({frame, start_ns + wire_time(frame)});
  }

  SyncAttribution syncs{BusParams{.name = "can0", .bit_rate = 1e6}};
};

TEST_F(SyncAttributionTest, NothingIsAnsweredBeforeTheFirstSync) {
  EXPECT_EQ(frame_from(0).sync, 0u);
  syncs.sync_queued(ms);
  EXPECT_EQ(frame_from(ms - 10 * us).sync, 0u);
}

TEST_F(SyncAttributionTest, TheBeginningOfTheFrameDecides) {
  syncs.sync_queued(ms);
  syncs.sync_queued(2 * ms);
  const SyncAttribution::Answer before = frame_from(2 * ms + sync_ns - 1);
  EXPECT_EQ(before.sync, 1u);
  EXPECT_EQ(before.t_ns, ms + sync_ns);

  syncs.sync_queued(3 * ms);
  const SyncAttribution::Answer after = frame_from(3 * ms + sync_ns);
  EXPECT_EQ(after.sync, 3u);
  EXPECT_EQ(after.t_ns, 3 * ms + sync_ns);
}

TEST_F(SyncAttributionTest, AnyFrameInFlightDelaysSync) {
  syncs.sync_queued(ms);
  syncs.sync_queued(2 * ms);
  const CanFrame foreign{.id = 0x7FF, .size = 8};
  frame_from(2 * ms - 1 * us, foreign);
  const Nanoseconds sync_end_ns = 2 * ms - 1 * us + wire_time(foreign) + intermission_bits * us + sync_ns;
  const SyncAttribution::Answer answer = frame_from(sync_end_ns + intermission_bits * us);
  EXPECT_EQ(answer.sync, 2u);
  EXPECT_EQ(answer.t_ns, sync_end_ns);

  syncs.sync_queued(3 * ms);
  EXPECT_EQ(frame_from(3 * ms - 20 * us).t_ns, sync_end_ns);  // a late one gets the same time
}

TEST_F(SyncAttributionTest, AFrameThatEndedBeforeSyncWasQueuedDelaysNothing) {
  syncs.sync_queued(ms);
  syncs.sync_queued(2 * ms);
  frame_from(2 * ms - 300 * us);
  EXPECT_EQ(frame_from(2 * ms + 60 * us).t_ns, 2 * ms + sync_ns);
}

// Both frames are stamped when the host reads them. The answer still belongs to the last SYNC, and its sample
// is not younger than the answer.
TEST_F(SyncAttributionTest, LateStampsNeverMoveAnAnswerToTheSyncBefore) {
  syncs.sync_queued(ms);
  syncs.sync_queued(2 * ms);
  const CanFrame answer = cia406::make_position(1, 5);
  const Nanoseconds stamp_ns = 2 * ms + sync_ns + intermission_bits * us + wire_time(answer);
  syncs.on_frame({cia402::make_status(2, {}), stamp_ns});
  const SyncAttribution::Answer answered = syncs.on_frame({answer, stamp_ns});
  EXPECT_EQ(answered.sync, 2u);
  EXPECT_EQ(answered.t_ns, stamp_ns - wire_time(answer));
}

TEST_F(SyncAttributionTest, FramesOfUnknownRateAnswerNothing) {
  syncs.sync_queued(ms);
  CanFrame fd = cia406::make_position(1, 5);
  fd.fd = true;
  EXPECT_EQ(syncs.on_frame({fd, ms + 500 * us}).sync, 0u);
}

}  // namespace
}  // namespace godobject::test_sync_attribution
