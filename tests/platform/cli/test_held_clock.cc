// HeldClock: simulated time stands still while the program is held up, and is wall time otherwise.
#include <gtest/gtest.h>

#include "platform/cli/simulate/simulation.h"

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
  EXPECT_EQ(clock.advance(60 * ms, 11 * ms), 16 * ms);
  EXPECT_EQ(clock.held(), 44 * ms);
  EXPECT_EQ(clock.wall(17 * ms), 61 * ms);
  EXPECT_EQ(clock.advance(61 * ms, 17 * ms), 17 * ms);
  EXPECT_EQ(clock.held(), 44 * ms);
}

TEST(HeldClock, MakesUpForLateWakeUps) {
  HeldClock clock;
  EXPECT_EQ(clock.advance(3 * ms, 2 * ms), 3 * ms);
  EXPECT_EQ(clock.advance(3 * ms + 1, 2 * ms), 3 * ms + 1) << "time that was due before is not a hold";
  for (Nanoseconds wall = 4 * ms; wall < 500 * ms; wall += 4 * ms)
    EXPECT_EQ(clock.advance(wall, clock.now() + ms / 10), wall) << "frames of 0.1 ms on a busy machine";
  EXPECT_EQ(clock.held(), 0);
}

TEST(HeldClock, NeverRunsBackwards) {
  HeldClock clock;
  for (const Nanoseconds wall : {1, 40, 41, 42, 90, 90, 91, 300}) {
    const Nanoseconds before = clock.now();
    EXPECT_GE(clock.advance(wall * ms, before + ms / 2), before) << wall;
  }
}

}  // namespace
}  // namespace godobject::test::test_held_clock
