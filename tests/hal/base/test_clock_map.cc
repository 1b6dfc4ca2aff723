#include "hal/base/clock_map.h"

#include <gtest/gtest.h>

#include <random>

namespace godobject::test_clock_map {
namespace {

constexpr Nanoseconds ms = 1'000'000;

/// Messages at 500 Hz of a clock that is slow by `drift`. Their delay is 1 ms plus an exponential jitter of
/// 0.3 ms, and from `late_from` to `late_to` another 20 ms.
struct Source {
  double drift = 0;
  Nanoseconds late_from = 0, late_to = 0;
  std::mt19937 random{1};
  std::exponential_distribution<double> jitter{1 / 0.3e6};

  Nanoseconds host_of(Nanoseconds device) const {
    return 5'000'000'000 + device + static_cast<Nanoseconds>(drift * static_cast<double>(device));
  }
  Nanoseconds arrival_of(Nanoseconds device) {
    const bool late = device >= late_from && device < late_to;
    return host_of(device) + ms + static_cast<Nanoseconds>(jitter(random)) + (late ? 20 * ms : 0);
  }
};

/// Returns the largest error of the mapped time, beyond the constant delay of 1 ms, after the first seconds.
double worst_us(Source source, int seconds) {
  ClockMap map;
  double worst = 0;
  for (Nanoseconds device = 0; device < seconds * (1000 * ms); device += 2 * ms) {
    map.add(device, source.arrival_of(device));
    if (device < 3000 * ms) continue;
    const double error = static_cast<double>(map.to_host(device) - source.host_of(device) - ms) * 1e-3;
    worst = std::max(worst, std::abs(error));
  }
  return worst;
}

TEST(ClockMap, JitterIsNotInTheMappedTime) { EXPECT_LT(worst_us({}, 20), 25); }

TEST(ClockMap, DriftIsFollowed) {
  for (const double drift : {80e-6, -80e-6}) EXPECT_LT(worst_us({.drift = drift}, 60), 40);
  ClockMap map;
  Source source{.drift = 80e-6};
  for (Nanoseconds device = 0; device < 10'000 * ms; device += 2 * ms)
    map.add(device, source.arrival_of(device));
  EXPECT_NEAR(map.drift_ppm(), 80, 8);
}

TEST(ClockMap, AWindowInWhichAllIsLateIsLeftOut) {
  EXPECT_LT(worst_us({.late_from = 8000 * ms, .late_to = 8500 * ms}, 20), 100);
}

TEST(ClockMap, BeforeThereIsALineTheLeastDelayCounts) {
  ClockMap map;
  EXPECT_EQ(map.to_host(7), 7);
  map.add(0, 1000 + 5 * ms);
  map.add(2 * ms, 1000 + 3 * ms);
  map.add(4 * ms, 1000 + 9 * ms);
  EXPECT_EQ(map.to_host(4 * ms), 1000 + 5 * ms);
}

TEST(UnwrappedCount, GoesOnBeyondTheWrap) {
  UnwrappedCount count;
  EXPECT_EQ(count.unwrap(0xFFFFFFF0u), 0xFFFFFFF0);
  EXPECT_EQ(count.unwrap(0x00000010u), 0x100000010);
  EXPECT_EQ(count.unwrap(0xFFFFFFFFu), 0xFFFFFFFF);
}

}  // namespace
}  // namespace godobject::test_clock_map
