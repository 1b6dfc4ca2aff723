// Forces that oscillate between their bounds, and forces that do not.
#include "hal/rig/swing_watch.h"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <random>

namespace godobject::test_swing_watch {
namespace {

constexpr double T = 1e-3, bound = 10, rate = 500;  // s, N, N/s: the defaults

/// Watches a desired force, bounded as by the core. Returns the time until oscillation is detected, s.
template <class Wish>
std::optional<double> noticed_after(double duration_s, Wish wish, double period_s = T) {
  SwingWatch watch(bound, rate, period_s);
  double shown = 0;
  for (int k = 1; k * period_s <= duration_s; ++k) {
    const double wanted = wish(k * period_s);
    const double sized = std::clamp(wanted, -bound, bound);
    const double next = std::clamp(sized, shown - rate * period_s, shown + rate * period_s);
    shown = next;
    if (watch.update(shown, shown != wanted)) return k * period_s;
  }
  return std::nullopt;
}

double sine(double amplitude, double hz, double t) {
  return amplitude * std::sin(2 * std::numbers::pi * hz * t);
}

TEST(SwingWatch, ChatterAtTheRateLimitIsNoticedWithin600Ms) {
  for (const double hz : {25.0, 50.0, 105.0, 250.0, 499.0}) {
    const auto after = noticed_after(2, [hz](double t) { return sine(100, hz, t) >= 0 ? 100.0 : -100.0; });
    ASSERT_TRUE(after) << hz;
    EXPECT_LE(*after, 0.6) << hz;
  }
}

TEST(SwingWatch, SwingsBetweenTheBoundsOfSizeAreNoticed) {
  SwingWatch watch(bound, 1e12, T);
  std::optional<double> after;
  for (int k = 1; k <= 1000 && !after; ++k)
    if (watch.update(k % 10 < 5 ? bound : -bound, true)) after = k * T;
  ASSERT_TRUE(after);
  EXPECT_LE(*after, 0.6);
}

TEST(SwingWatch, ChatterIsNoticedAtOtherPeriods) {
  for (const double period : {2.5e-4, 2e-3, 4e-3}) {
    const auto after = noticed_after(
        2, [](double t) { return sine(100, 60, t); }, period);
    ASSERT_TRUE(after) << period;
    EXPECT_LE(*after, 0.6) << period;
  }
}

TEST(SwingWatch, AHandThatMovesAt10HzAtTheRateLimitIsNotChatter) {
  EXPECT_FALSE(noticed_after(10, [](double t) { return sine(1000, 10, t); }));
}

TEST(SwingWatch, TappingAStiffWallIsNotChatter) {
  // eight taps a second, 30 ms of contact each, with a ringing of 120 Hz that decays within it
  const auto tap = [](double t) {
    const double since = std::fmod(t, 0.125);
    return since < 0.03
               ? 40 * (1 - std::exp(-since / 2e-3)) + 20 * std::exp(-since / 5e-3) * sine(1, 120, since)
               : 0.0;
  };
  EXPECT_FALSE(noticed_after(10, tap));
}

TEST(SwingWatch, ATextureOf30HzBelowTheLimitsIsNotChatter) {
  EXPECT_FALSE(noticed_after(10, [](double t) { return 4 + sine(2, 30, t); }));
}

TEST(SwingWatch, PressingHardWithATremorIsNotChatter) {
  // at the bound of magnitude in every cycle, with noise of 0.03 N
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.03);
  SwingWatch watch(bound, rate, T);
  for (int k = 0; k < 10000; ++k) EXPECT_FALSE(watch.update(bound - std::abs(noise(random)), true));
}

TEST(SwingWatch, AShortBurstIsNotChatterAndAResetForgets) {
  EXPECT_FALSE(noticed_after(10, [](double t) { return std::fmod(t, 2) < 0.35 ? sine(1000, 60, t) : 0.0; }));
  SwingWatch watch(bound, rate, T);
  for (int round = 0; round < 3; ++round) {
    for (int k = 1; k <= 490; ++k) EXPECT_FALSE(watch.update(k % 2 ? 0.5 : 0, true));
    watch.reset();
  }
}

}  // namespace
}  // namespace godobject::test_swing_watch
