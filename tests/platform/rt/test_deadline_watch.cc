// Consequences of missed deadlines, counted in periods, so that the test is deterministic.
#include "platform/rt/cyclic.h"

#include <gtest/gtest.h>

namespace godobject::test_deadline_watch {
namespace {

void keep(DeadlineWatch& watch, int cycles) {
  for (int i = 0; i < cycles; ++i) watch.add(false, 0);
}

TEST(DeadlineWatch, FourInAWindowAreNone) {
  DeadlineWatch watch(1e-3);
  for (int i = 0; i < 100; ++i) {
    watch.add(true, 0);
    keep(watch, 24);
    ASSERT_FALSE(watch.holds()) << i;
    ASSERT_FALSE(watch.lost());
  }
}

TEST(DeadlineWatch, FiveInAWindowHoldUntilThereAreFewer) {
  DeadlineWatch watch(1e-3);
  keep(watch, 200);
  for (int i = 0; i < 5; ++i) {
    ASSERT_FALSE(watch.holds());
    keep(watch, 9);
    watch.add(i % 2 == 0, i % 2 == 0 ? 0 : 1);  // late cycles and skipped periods count alike
  }
  EXPECT_TRUE(watch.holds());
  int held = 0;
  for (; watch.holds() && held < 200; ++held) watch.add(false, 0);
  EXPECT_NEAR(held, 100 - 42, 2) << "until the first of the five is 100 ms ago";
}

TEST(DeadlineWatch, PeriodsLeftOutAtOnceCountOneByOne) {
  DeadlineWatch watch(1e-3);
  keep(watch, 10);
  watch.add(false, 4);
  EXPECT_FALSE(watch.holds());
  keep(watch, 200);
  watch.add(false, 5);
  EXPECT_TRUE(watch.holds());
  EXPECT_FALSE(watch.lost());
  keep(watch, 200);
  watch.add(false, 19);
  EXPECT_FALSE(watch.lost());
  watch.add(true, 0);
  EXPECT_TRUE(watch.lost()) << "late, and 19 before it: 20 in a row";
  keep(watch, 1);
  EXPECT_FALSE(watch.lost());
}

TEST(DeadlineWatch, TheWindowIsOfTimeNotOfPeriods) {
  DeadlineWatch slow(0.01);  // ten periods
  for (int i = 0; i < 50; ++i) {
    slow.add(i % 3 == 0, 0);
    ASSERT_FALSE(slow.holds()) << i;
  }
  slow.add(false, 5);
  EXPECT_TRUE(slow.holds());
}

TEST(DeadlineWatch, AHoldOf2sIsAFault) {
  DeadlineWatch watch(1e-3);
  int held = 0;
  for (; !watch.lost() && held < 3000; ++held) watch.add(held % 19 == 0, 0);  // five in each window
  EXPECT_NEAR(held, 2000 + 4 * 19, 2);
  keep(watch, 200);
  EXPECT_FALSE(watch.lost());
  for (int i = 0; i < 1900; ++i) watch.add(i % 19 == 0, 0);
  keep(watch, 200);  // kept in between
  for (int i = 0; i < 1900; ++i) {
    watch.add(i % 19 == 0, 0);
    ASSERT_FALSE(watch.lost()) << i;
  }
}

TEST(DeadlineWatch, ResetForgets) {
  DeadlineWatch watch(1e-3);
  watch.add(true, 30);
  ASSERT_TRUE(watch.holds() && watch.lost());
  watch.reset();
  EXPECT_FALSE(watch.holds() || watch.lost());
}

/// Sleeps in time but for one sleep that takes `stall` longer.
struct FakeClock {
  Nanoseconds t = 0, stall = 0;

  Nanoseconds now() const { return t; }
  void sleep_until(Nanoseconds until) {
    t = std::max(t, until) + stall;
    stall = 0;
  }
};

/// The loop passes all data that the watch needs.
TEST(DeadlineWatch, HearsOfTheLoop) {
  constexpr Nanoseconds ms = 1'000'000;
  for (const auto& [stall, holds, lost] :
       {std::tuple{3 * ms, false, false}, std::tuple{5 * ms, true, false}, std::tuple{25 * ms, true, true}}) {
    FakeClock clock;
    Cyclic loop(clock, ms);
    DeadlineWatch watch(1e-3);
    int cycle = 0;
    bool held = false, was_lost = false;
    loop.run([&](const Wake& wake) {
      watch.add(wake.late_before, wake.skipped);
      held = held || watch.holds();
      was_lost = was_lost || watch.lost();
      if (cycle == 50) clock.stall = stall;
      return ++cycle < 300;
    });
    EXPECT_EQ(held, holds) << stall;
    EXPECT_EQ(was_lost, lost) << stall;
    EXPECT_FALSE(watch.holds()) << "100 ms later";
  }
}

}  // namespace
}  // namespace godobject::test_deadline_watch
