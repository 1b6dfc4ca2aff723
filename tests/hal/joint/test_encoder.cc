#include "hal/joint/encoder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace godobject::test_encoder {
namespace {

constexpr Nanoseconds ms = 1'000'000;

Calibration turn_of_4096() {
  Calibration c;
  c.counts_per_unit = 1000;
  c.modulus_counts = 4096;
  return c;
}

// 1 ms samples, one count is 1e-3: max_speed 50 allows 50 counts per sample.
Encoder make_encoder(const Calibration& calibration) { return Encoder(calibration, 50, 3 * ms); }

TEST(Encoder, SignScaleOffset) {
  Calibration c = turn_of_4096();
  c.sign = -1;
  c.offset_counts = 100;
  Encoder encoder = make_encoder(c);
  encoder.update(350, ms);
  EXPECT_DOUBLE_EQ(encoder.sample(ms).q, -0.25);
  EXPECT_TRUE(encoder.sample(ms).valid);
  EXPECT_EQ(encoder.sample(2 * ms).age(2 * ms), ms);
}

TEST(Encoder, HomeIsTheCoordinateAtTheOffset) {
  Calibration c = turn_of_4096();
  c.sign = -1;
  c.offset_counts = 100;
  c.home = 0.7;  // the jig holds the joint there
  Encoder encoder = make_encoder(c);
  encoder.update(100, ms);
  EXPECT_DOUBLE_EQ(encoder.sample(ms).q, 0.7);
  encoder.update(140, 2 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(2 * ms).q, 0.7 - 0.04);
  EXPECT_NEAR(encoder.sample(2 * ms).q_dot, -40, 1e-9);
}

TEST(Encoder, FirstSampleTakesTheTurnNearestHome) {
  Calibration c = turn_of_4096();
  c.offset_counts = 4000;
  c.home = 10;  // two and a half turns from 0
  Encoder below = make_encoder(c), above = make_encoder(c);
  below.update(4000 - 2048, ms);
  EXPECT_DOUBLE_EQ(below.sample(ms).q, 10 - 2.048);
  above.update(1, ms);  // past the wrap
  EXPECT_DOUBLE_EQ(above.sample(ms).q, 10 + 0.097);
  for (std::uint32_t k = 2; k < 60; ++k) above.update(40 * (k - 1), k * ms);
  EXPECT_DOUBLE_EQ(above.sample(59 * ms).q, 10 + 0.096 + 0.040 * 58);
}

TEST(Encoder, FirstSampleTakesTheTurnNearestZero) {
  Encoder encoder = make_encoder(turn_of_4096());
  encoder.update(4095, ms);
  EXPECT_DOUBLE_EQ(encoder.sample(ms).q, -1e-3);
}

TEST(Encoder, FollowsManyTurnsBothWays) {
  Encoder encoder = make_encoder(turn_of_4096());
  std::int64_t counts = 0;
  Nanoseconds t = 0;
  const auto run = [&](std::int64_t step, int samples) {
    for (int k = 0; k < samples; ++k) {
      counts += step;
      const std::int64_t wrapped = ((counts % 4096) + 4096) % 4096;
      encoder.update(static_cast<std::uint32_t>(wrapped), t += ms);
      ASSERT_DOUBLE_EQ(encoder.sample(t).q, static_cast<double>(counts) / 1000);
    }
  };
  run(37, 400);
  run(-41, 900);
  EXPECT_EQ(encoder.counters().implausible, 0u);
  EXPECT_NEAR(encoder.sample(t).q_dot, -41, 1e-9);
}

TEST(Encoder, ThirtyTwoBitsWhereThereIsNoModulus) {
  Calibration c;
  c.counts_per_unit = 1000;
  Encoder encoder = make_encoder(c);
  encoder.update(static_cast<std::uint32_t>(-3), ms);
  EXPECT_DOUBLE_EQ(encoder.sample(ms).q, -3e-3);
  encoder.update(4, 2 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(2 * ms).q, 4e-3);
}

TEST(Encoder, OneSpikeIsOneInvalidCycle) {
  Encoder encoder = make_encoder(turn_of_4096());
  for (int k = 0; k < 10; ++k) encoder.update(100, k * ms);
  encoder.update(1500, 10 * ms);
  EXPECT_FALSE(encoder.sample(10 * ms).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(10 * ms).q, 0.1);
  EXPECT_EQ(encoder.counters().implausible, 1u);
  EXPECT_TRUE(encoder.trusted());
  encoder.update(101, 11 * ms);
  EXPECT_TRUE(encoder.sample(11 * ms).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(11 * ms).q, 0.101);
}

TEST(Encoder, CountsOutsideTheModulusAreImplausible) {
  Encoder encoder = make_encoder(turn_of_4096());
  encoder.update(4096, ms);
  EXPECT_FALSE(encoder.has_sample());
  EXPECT_EQ(encoder.counters().implausible, 1u);
}

TEST(Encoder, BoundGrowsWithTheTimeThatHasPassed) {
  Encoder encoder = make_encoder(turn_of_4096());
  encoder.update(0, ms);
  encoder.update(2 * 50, 3 * ms);  // one sample missed at full speed
  EXPECT_TRUE(encoder.sample(3 * ms).valid);
  encoder.update(2 * 50 + 52, 4 * ms);
  EXPECT_FALSE(encoder.sample(4 * ms).valid);
}

TEST(Encoder, JumpThatPersistsIsTakenOverAfterVotesAndReported) {
  Encoder encoder = make_encoder(turn_of_4096());
  for (int k = 0; k < 10; ++k) encoder.update(100, k * ms);
  for (int k = 10; k < 12; ++k) {
    encoder.update(1500, k * ms);
    EXPECT_FALSE(encoder.sample(k * ms).valid);
    EXPECT_TRUE(encoder.trusted());
  }
  encoder.update(1501, 12 * ms);
  EXPECT_TRUE(encoder.sample(12 * ms).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(12 * ms).q, 1.501);
  EXPECT_EQ(encoder.sample(12 * ms).q_dot, 0);
  EXPECT_EQ(encoder.counters().resyncs, 1u);
  EXPECT_FALSE(encoder.trusted());
  for (int k = 13; k < 18; ++k) encoder.update(1501, k * ms);
  EXPECT_TRUE(encoder.trusted());
}

TEST(Encoder, GarbageThatDisagreesWithItselfIsNeverTakenOver) {
  Encoder encoder = make_encoder(turn_of_4096());
  encoder.update(100, 0);
  for (int k = 1; k < 20; ++k) {
    encoder.update(k % 2 == 0 ? 1600 : 2900, k * ms);
    EXPECT_FALSE(encoder.sample(k * ms).valid);
  }
  EXPECT_EQ(encoder.counters().resyncs, 0u);
  EXPECT_FALSE(encoder.trusted());
}

TEST(Encoder, StaleAfterTheLimit) {
  Encoder encoder = make_encoder(turn_of_4096());
  EXPECT_TRUE(encoder.stale(0));
  encoder.update(100, ms);
  EXPECT_FALSE(encoder.stale(4 * ms));
  EXPECT_TRUE(encoder.sample(4 * ms).valid);
  EXPECT_TRUE(encoder.stale(4 * ms + 1));
  EXPECT_FALSE(encoder.sample(4 * ms + 1).valid);
}

Calibration incremental(std::uint64_t modulus_counts) {
  return {.counts_per_unit = 1000, .modulus_counts = modulus_counts, .home = 0.7, .incremental = true};
}

TEST(Encoder, AnIncrementalSensorIsNotValidBeforeItsZero) {
  Encoder encoder = make_encoder(incremental(0));
  EXPECT_TRUE(encoder.is_incremental());
  encoder.update(123'456, ms);
  encoder.update(123'496, 2 * ms);
  EXPECT_TRUE(encoder.good(2 * ms));
  EXPECT_FALSE(encoder.sample(2 * ms).valid);
  encoder.set_zero();
  EXPECT_TRUE(encoder.sample(2 * ms).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(2 * ms).q, 0.7);
  EXPECT_EQ(encoder.sample(2 * ms).q_dot, 0) << "the zero is no motion";
  encoder.update(123'500, 3 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(3 * ms).q, 0.704);
  EXPECT_NEAR(encoder.sample(3 * ms).q_dot, 4, 1e-9);
  encoder.drop_zero();
  EXPECT_FALSE(encoder.sample(3 * ms).valid);
}

TEST(Encoder, AnAbsoluteSensorKeepsItsZero) {
  Encoder encoder = make_encoder(turn_of_4096());
  EXPECT_TRUE(encoder.has_zero());
  encoder.update(100, ms);
  encoder.drop_zero();
  EXPECT_TRUE(encoder.sample(ms).valid);
}

TEST(Encoder, WithoutASampleThereIsNoZero) {
  Encoder encoder = make_encoder(incremental(0));
  encoder.set_zero();
  EXPECT_FALSE(encoder.has_zero());
}

TEST(Encoder, AnIncrementalSensorCountsTurnsFromItsZeroOn) {
  Encoder encoder = make_encoder(incremental(4096));
  std::uint32_t counts = 4000;
  Nanoseconds t = 0;
  const auto turn = [&](int steps) {
    for (int i = 0; i < steps; ++i) encoder.update(counts = (counts + 40) % 4096, t += ms);
  };
  turn(300);
  encoder.set_zero();
  turn(250);
  EXPECT_DOUBLE_EQ(encoder.sample(t).q, 0.7 + 10);
}

TEST(Encoder, AResyncDropsTheZero) {
  Encoder jumped = make_encoder(incremental(0)), silent = make_encoder(incremental(4096));
  for (Encoder* const encoder : {&jumped, &silent}) {
    encoder->update(100, ms);
    encoder->set_zero();
  }
  for (Nanoseconds i = 2; i <= 4; ++i) jumped.update(2000, i * ms);
  EXPECT_TRUE(jumped.good(4 * ms));
  EXPECT_FALSE(jumped.has_zero()) << "counts were lost, or the sensor was reset";
  silent.update(120, 500 * ms);
  EXPECT_TRUE(silent.good(500 * ms));
  EXPECT_FALSE(silent.has_zero()) << "its turn is unknown";
}

TEST(Encoder, DuplicateIsIgnored) {
  Encoder encoder = make_encoder(turn_of_4096());
  encoder.update(100, ms);
  encoder.update(105, ms);
  EXPECT_DOUBLE_EQ(encoder.sample(ms).q, 0.1);
  EXPECT_TRUE(encoder.sample(ms).valid);
  EXPECT_EQ(encoder.counters().out_of_order, 1u);
}

TEST(Encoder, TurnIsRestartedAfterAGapLongEnoughForHalfATurn) {
  Encoder encoder = make_encoder(turn_of_4096());
  for (int k = 0; k <= 100; ++k) encoder.update(static_cast<std::uint32_t>(k * 45 % 4096), k * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(100 * ms).q, 4.5);
  encoder.update(300, 200 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(200 * ms).q, 0.3);
  EXPECT_EQ(encoder.sample(200 * ms).q_dot, 0) << "nothing is known of the gap";
  EXPECT_EQ(encoder.counters().resyncs, 1u);
}

}  // namespace
}  // namespace godobject::test_encoder
