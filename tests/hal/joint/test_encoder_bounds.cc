// Bounds of an encoder's samples, at their last accepted value.
#include <gtest/gtest.h>

#include "hal/joint/encoder.h"

namespace godobject::test_encoder_bounds {
namespace {

constexpr Nanoseconds ms = 1'000'000;

/// 1 ms samples: max_speed allows two counts per sample.
Encoder slow_encoder() { return Encoder({.counts_per_unit = 1000, .modulus_counts = 4096}, 2, 3 * ms); }

TEST(EncoderBounds, TravelIsThatOfMaxSpeedAndOneCount) {
  for (const std::uint32_t travel : {3u, 4u}) {
    Encoder encoder = slow_encoder();
    encoder.update(100, ms);
    encoder.update(100 + travel, 2 * ms);
    EXPECT_EQ(encoder.sample(2 * ms).valid, travel == 3) << travel;
  }
}

TEST(EncoderBounds, CountsOutsideTheModulusAreVotes) {
  Encoder encoder = slow_encoder();
  encoder.update(100, ms);
  for (int i = 0; i < Encoder::votes_needed; ++i) {
    EXPECT_TRUE(encoder.trusted()) << i;
    encoder.update(4096, (2 + i) * ms);
  }
  EXPECT_FALSE(encoder.trusted());
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
