#include "sim/node/encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hal/canopen/cia406.h"

namespace godobject::test_sim_encoder {
namespace {

TEST(SimEncoder, CountsInvertTheCalibration) {
  const Calibration c{.counts_per_unit = 1000, .sign = -1, .offset_counts = 500, .modulus_counts = 4096};
  EXPECT_EQ(counts_at(0, c), 500u);
  EXPECT_EQ(counts_at(0.1, c), 400u);
  EXPECT_EQ(counts_at(-0.1, c), 600u);
  for (double q = -0.4; q < 0.49; q += 0.0137) {
    const double back = c.sign * (static_cast<double>(counts_at(q, c)) - 500) / c.counts_per_unit;
    EXPECT_NEAR(back, q, 0.5 / c.counts_per_unit + 1e-12);
  }
}

TEST(SimEncoder, CountsAreTheOffsetAtHome) {
  const Calibration c{
      .counts_per_unit = 1000, .sign = -1, .offset_counts = 500, .modulus_counts = 4096, .home = -0.8};
  EXPECT_EQ(counts_at(-0.8, c), 500u);
  EXPECT_EQ(counts_at(-0.7, c), 400u);
  EXPECT_EQ(counts_at(-0.8 + 0.501, c), 4095u);
}

TEST(SimEncoder, CountsWrapBothWaysAtTheModulus) {
  const Calibration c{.counts_per_unit = 1, .modulus_counts = 4096};
  EXPECT_EQ(counts_at(4095, c), 4095u);
  EXPECT_EQ(counts_at(4095.6, c), 0u);
  EXPECT_EQ(counts_at(-1, c), 4095u);
  EXPECT_EQ(counts_at(-4096, c), 0u);
  EXPECT_EQ(counts_at(3 * 4096 + 7, c), 7u);
}

TEST(SimEncoder, WithoutModulusCountsWrapAt32Bits) {
  const Calibration c{.counts_per_unit = 1};
  EXPECT_EQ(counts_at(-1, c), 0xFFFFFFFFu);
  EXPECT_EQ(counts_at(4294967296.0, c), 0u);
  EXPECT_EQ(counts_at(3e9, c), 3'000'000'000u);
}

TEST(SimEncoder, NonsenseDoesNotOverflow) {
  const Calibration c{.counts_per_unit = 1e6, .offset_counts = -7, .modulus_counts = 1000};
  for (const double q : {1e300, -1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_LT(counts_at(q, c), 1000u);
  }
  EXPECT_EQ(counts_at(std::numeric_limits<double>::quiet_NaN(), c), 0x8000'0000u);  // no value
}

TEST(SimEncoder, SamplesWhenSyncArrives) {
  SimCanWire wire({});
  SimCanPort host(wire), port(wire);
  ASSERT_TRUE(host.open() && port.open());
  SimEncoder encoder(port, 3, {.counts_per_unit = 1000}, 0);
  SimCanopenNode* const nodes[] = {&encoder};
  ASSERT_EQ(host.try_send(canopen::make_nmt(canopen::NmtCommand::start, 3)), SendResult::queued);
  advance(wire, nodes, 1'000'000);

  encoder.set_position(1);
  ASSERT_EQ(host.try_send(canopen::make_sync()), SendResult::queued);
  advance(wire, nodes, 1'000'000 + 60'000);  // SYNC has arrived, the answer is on the wire
  encoder.set_position(2);
  advance(wire, nodes, 2'000'000);
  std::uint32_t counts = 0;
  int positions = 0;
  for (ReceivedFrame received; host.try_receive(received);) {
    if (cia406::parse_position(received.frame, 3, counts) == ParseResult::ok) ++positions;
  }
  EXPECT_EQ(positions, 1);
  EXPECT_EQ(counts, 1000u);
}

}  // namespace
}  // namespace godobject::test_sim_encoder
