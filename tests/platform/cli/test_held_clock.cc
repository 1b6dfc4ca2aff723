// HeldClock: simulated time stands still while the program is held up, and is wall time otherwise.
#include <gtest/gtest.h>

#include "platform/cli/simulate/held_clock.h"

namespace godobject::test::test_held_clock {
namespace {

constexpr Nanoseconds ms = 1'000'000;

TEST(HeldClock, IsWallTimeWhileItIsReadInTime) {
  HeldClock clock;
  Nanoseconds due = 0;
  for (Nanoseconds wall = ms / 2; wall < 50 * ms; wall += 7 * ms / 10) {
    EXPECT_EQ(clock.advance(wall, due), wall);
    due = wall + ms;  // frames wake it earlier
  }
  EXPECT_EQ(clock.held(), 0);
}

TEST(HeldClock, StandsStillWhileTheProgramIsHeldUp) {
  HeldClock clock;
  EXPECT_EQ(clock.advance(10 * ms, 10 * ms), 10 * ms);
  EXPECT_EQ(clock.advance(60 * ms, 11 * ms), 11 * ms);
  EXPECT_EQ(clock.held(), 49 * ms);
  EXPECT_EQ(clock.wall(12 * ms), 61 * ms);
  EXPECT_EQ(clock.advance(61 * ms, 12 * ms), 12 * ms);
  EXPECT_EQ(clock.held(), 49 * ms);
}

TEST(HeldClock, ToleratesALateWakeUp) {
  HeldClock clock;
  EXPECT_EQ(clock.advance(3 * ms, 2 * ms), 3 * ms);
  EXPECT_EQ(clock.advance(3 * ms + 1, 2 * ms), 3 * ms + 1) << "what was due before is not a hold";
  EXPECT_EQ(clock.held(), 0);
}

TEST(HeldClock, NeverRunsBackwards) {
  HeldClock clock;
  Nanoseconds before = 0;
  for (const Nanoseconds wall : {1, 40, 41, 42, 90, 90, 91, 300}) {
    const Nanoseconds now = clock.advance(wall * ms, before + ms / 2);
    EXPECT_GE(now, before) << wall;
    before = now;
  }
}

}  // namespace
}  // namespace godobject::test::test_held_clock
