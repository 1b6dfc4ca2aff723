// Bounds of an encoder's samples, at their last accepted value.
#include <gtest/gtest.h>

#include "hal/joint/encoder.h"

namespace godobject::test_encoder_bounds {
namespace {

constexpr Nanoseconds ms = 1'000'000;

/// 1 ms samples: max_speed allows exactly three counts per sample.
Encoder slow_encoder() { return Encoder({.counts_per_unit = 1000, .modulus_counts = 4096}, 3, 3 * ms); }

TEST(EncoderBounds, TravelIsThatOfMaxSpeedAndOneCount) {
  for (const std::uint32_t travel : {4u, 5u}) {
    Encoder encoder = slow_encoder();
    encoder.update(100, ms);
    encoder.update(100 + travel, 2 * ms);
    EXPECT_EQ(encoder.sample(2 * ms).valid, travel == 4) << travel;
  }
}

// The bound of a joint that cannot move is one count, without rounding.
TEST(EncoderBounds, TravelOfTheBoundIsAccepted) {
  for (const std::uint32_t travel : {1u, 2u}) {
    Encoder encoder({.counts_per_unit = 1000, .modulus_counts = 4096}, 0, 3 * ms);
    encoder.update(100, ms);
    encoder.update(100 + travel, 2 * ms);
    EXPECT_EQ(encoder.sample(2 * ms).valid, travel == 1) << travel;
  }
}

TEST(EncoderBounds, CountsOutsideTheModulusAreVotes) {
  Encoder encoder = slow_encoder();
  encoder.update(100, ms);
  for (int i = 0; i < Encoder::votes_needed; ++i) {
    EXPECT_TRUE(encoder.trusted()) << i;
    encoder.update(4096, (2 + i) * ms);
    EXPECT_FALSE(encoder.sample((2 + i) * ms).valid);
  }
  EXPECT_FALSE(encoder.trusted());
}

TEST(EncoderBounds, OddModulusWrapsToo) {
  Encoder encoder({.counts_per_unit = 1000, .modulus_counts = 4095}, 50, 3 * ms);
  encoder.update(10, ms);
  encoder.update(4090, 2 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(2 * ms).q, -0.005);
  encoder.update(20, 3 * ms);
  EXPECT_DOUBLE_EQ(encoder.sample(3 * ms).q, 0.02);
}

TEST(EncoderBounds, CountOutsideTheModulusEndsAnAgreement) {
  Encoder encoder = slow_encoder();
  Nanoseconds t = 0;
  for (const std::uint32_t counts : {100u, 2000u, 4096u, 2000u, 2000u}) {
    t += ms;
    encoder.update(counts, t);
  }
  EXPECT_FALSE(encoder.sample(t).valid) << "two agree";
  encoder.update(2000, t + ms);
  EXPECT_TRUE(encoder.sample(t + ms).valid) << "three agree";
}

TEST(EncoderBounds, CopiesOfASpikeDoNotAgree) {
  Encoder encoder = slow_encoder();
  encoder.update(100, ms);
  for (int i = 0; i < Encoder::votes_needed; ++i) encoder.update(2000, 2 * ms);
  EXPECT_FALSE(encoder.sample(2 * ms).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(2 * ms).q, 0.1);
}

// Half of 4096 counts at 50 counts per ms: 40.96 ms.
TEST(EncoderBounds, TurnIsLostAfterHalfOfIt) {
  Encoder encoder({.counts_per_unit = 1000, .modulus_counts = 4096}, 50, 3 * ms);
  EXPECT_FALSE(encoder.turn_is_lost(100 * ms)) << "no sample yet";
  encoder.update(100, 0);
  EXPECT_FALSE(encoder.turn_is_lost(40 * ms));
  EXPECT_TRUE(encoder.turn_is_lost(41 * ms));
}

TEST(EncoderBounds, TurnIsLostAtExactlyHalfOfIt) {
  Encoder encoder({.counts_per_unit = 1000, .modulus_counts = 4000}, 50, 3 * ms);
  encoder.update(100, 0);
  EXPECT_TRUE(encoder.turn_is_lost(40 * ms));
  EXPECT_FALSE(encoder.turn_is_lost(40 * ms - 1000));
}

TEST(EncoderBounds, TurnIsNotLostBeforeTheSampleIsStale) {
  Encoder encoder({.counts_per_unit = 1000, .modulus_counts = 64}, 50, 3 * ms);
  encoder.update(10, 0);
  EXPECT_FALSE(encoder.turn_is_lost(3 * ms));
  EXPECT_TRUE(encoder.turn_is_lost(3 * ms + 1));
}

// A step of two counts leaves the noise band of one count, so the window is short.
TEST(EncoderBounds, NoiseOfTheVelocityIsOneCount) {
  Encoder encoder = slow_encoder();
  for (int i = 1; i <= 15; ++i) encoder.update(100, i * ms);
  encoder.update(102, 16 * ms);
  EXPECT_GT(encoder.sample(16 * ms).q_dot, 0.2);
}

TEST(EncoderBounds, StaleSampleIsAtRest) {
  Encoder encoder = slow_encoder();
  encoder.update(100, ms);
  encoder.update(102, 2 * ms);
  EXPECT_GT(encoder.sample(5 * ms).q_dot, 0);
  EXPECT_TRUE(encoder.sample(5 * ms).valid) << "3 ms old";
  EXPECT_EQ(encoder.sample(5 * ms + 1).q_dot, 0);
  EXPECT_FALSE(encoder.sample(5 * ms + 1).valid);
  EXPECT_DOUBLE_EQ(encoder.sample(5 * ms + 1).q, 0.102);
}

}  // namespace
}  // namespace godobject::test_encoder_bounds
