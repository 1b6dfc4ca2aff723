#include "hal/base/stamp_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace godobject::test_stamp_clock {
namespace {

constexpr Nanoseconds us = 1'000, ms = 1'000'000, s = 1'000'000'000;

TEST(StampClock, TheFirstFrameIsTakenForUndelayed) {
  StampClock clock;
  EXPECT_EQ(clock.to_local(5 * s, 100 * s), 100 * s);
}

TEST(StampClock, DelayOfArrivalDoesNotShow) {
  StampClock clock;
  static_cast<void>(clock.to_local(0, 100 * s));
  EXPECT_EQ(clock.to_local(1 * ms, 100 * s + 4 * ms), 100 * s + 1 * ms + 1 * ms / StampClock::drift_divisor);
}

// A crystal off by 50 ppm, with frames every millisecond, delayed by an exponential of 100 us, for an hour.
TEST(StampClock, FollowsADriftingClock) {
  for (const double drift : {50e-6, -50e-6}) {
    StampClock clock;
    std::mt19937 random(1);
    std::exponential_distribution<double> delay(1.0 / 100e3);
    Nanoseconds worst = 0;
    for (Nanoseconds t = 0; t < 3600 * s; t += ms) {
      const auto stamp = static_cast<Nanoseconds>(static_cast<double>(t) * (1 + drift));
      const Nanoseconds arrival = 7 * s + t + static_cast<Nanoseconds>(delay(random));
      const Nanoseconds local = clock.to_local(stamp, arrival);
      ASSERT_LE(local, arrival);
      if (t > s) worst = std::max(worst, std::abs(local - (7 * s + t)));
    }
    EXPECT_LT(worst, 50 * us) << drift;
  }
}

TEST(StampClock, AClockThatIsSetIsFollowedAtOnce) {
  StampClock clock;
  static_cast<void>(clock.to_local(50 * s, 100 * s));
  EXPECT_EQ(clock.to_local(0, 101 * s), 101 * s);
  EXPECT_EQ(clock.to_local(1 * ms, 101 * s + 1 * ms), 101 * s + 1 * ms);
  EXPECT_EQ(clock.to_local(500 * s, 102 * s), 102 * s);
}

}  // namespace
}  // namespace godobject::test_stamp_clock
