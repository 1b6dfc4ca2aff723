// The loop on a clock controlled by the test: late cycles, skipped periods, and a constant phase.
#include "platform/rt/cyclic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace godobject::test_cyclic {
namespace {

using testing::ElementsAre;

constexpr Nanoseconds period = 1000;

/// Wakes exactly in time, or once `oversleep` later.
struct FakeClock {
  Nanoseconds t = 0;
  Nanoseconds oversleep = 0;

  Nanoseconds now() const { return t; }
  void sleep_until(Nanoseconds until) {
    t = std::max(t, until) + oversleep;
    oversleep = 0;
  }
};

/// Runs one cycle per entry, with that duration; returns their start times.
std::vector<Nanoseconds> run(FakeClock& clock, Cyclic<FakeClock>& loop,
                             const std::vector<Nanoseconds>& costs) {
  std::vector<Nanoseconds> starts;
  loop.run([&](Nanoseconds) {
    starts.push_back(clock.t);
    clock.t += costs[starts.size() - 1];
    return starts.size() < costs.size();
  });
  return starts;
}

TEST(Cyclic, StartsOncePerPeriod) {
  FakeClock clock;
  Cyclic loop(clock, period);
  EXPECT_THAT(run(clock, loop, {300, 300, 1000}), ElementsAre(1000, 2000, 3000));
  EXPECT_EQ(loop.statistics().cycles, 3u);
  EXPECT_EQ(loop.statistics().missed(), 0u);
  EXPECT_EQ(loop.statistics().wake_ns.max(), 0);
  EXPECT_EQ(loop.statistics().cycle_ns.max(), 1000);
}

TEST(Cyclic, LateByLessThanAPeriodRunsAtOnceAndKeepsThePhase) {
  FakeClock clock;
  Cyclic loop(clock, period);
  EXPECT_THAT(run(clock, loop, {1400, 300, 300}), ElementsAre(1000, 2400, 3000));
  EXPECT_EQ(loop.statistics().late, 1u);
  EXPECT_EQ(loop.statistics().skipped, 0u);
  EXPECT_EQ(loop.statistics().wake_ns.max(), 400);
}

TEST(Cyclic, WholePeriodsMissedAreSkippedAndCounted) {
  FakeClock clock;
  Cyclic loop(clock, period);
  // The second release was at 2000: at 4400 those at 2000 and 3000 are over, and that of 4000 runs.
  EXPECT_THAT(run(clock, loop, {3400, 300, 300}), ElementsAre(1000, 4400, 5000));
  EXPECT_EQ(loop.statistics().late, 1u);
  EXPECT_EQ(loop.statistics().skipped, 2u);
  EXPECT_EQ(loop.statistics().missed(), 3u);
  EXPECT_EQ(loop.statistics().cycles, 3u);
}

TEST(Cyclic, OversleepingIsWakeUpLatencyAndDoesNotShiftLaterCycles) {
  FakeClock clock{.t = 0, .oversleep = 250};
  Cyclic loop(clock, period);
  EXPECT_THAT(run(clock, loop, {300, 300}), ElementsAre(1250, 2000));
  EXPECT_EQ(loop.statistics().wake_ns.max(), 250);
  EXPECT_EQ(loop.statistics().missed(), 0u);
}

TEST(Cyclic, LateStartThatEndsAfterItsPeriodIsLate) {
  FakeClock clock{.t = 0, .oversleep = 900};
  Cyclic loop(clock, period);
  EXPECT_THAT(run(clock, loop, {300, 300}), ElementsAre(1900, 2200));
  EXPECT_EQ(loop.statistics().late, 1u);
  EXPECT_EQ(loop.statistics().skipped, 0u);
}

TEST(MonotonicClock, NeverWakesEarly) {
  const MonotonicClock clock;
  const Nanoseconds until = clock.now() + 2'000'000;
  clock.sleep_until(until);
  EXPECT_GE(clock.now(), until);
}

}  // namespace
}  // namespace godobject::test_cyclic
