// The felt impedance against its law in continuous time, and the line between motion and force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/study/feel/feel.h"

namespace godobject::study::test_feel {
namespace {

double relative_error(const Impedance& felt, const Impedance& law) {
  return std::abs(felt.Z - law.Z) / std::abs(law.Z);
}

TEST(Feel, WithoutBusesIsThatOfTheLaw) {
  for (const double damping_ratio : {1.0, 1.4, 2.0})
    for (const bool is_pressed : {false, true}) {
      FeelCase c{.plan = feel_plans()[0], .damping_ratio = damping_ratio, .is_pressed = is_pressed};
      for (const double f_Hz : feel_frequencies(2)) {
        const double bound = f_Hz > 40 ? 0.03 : 2e-3;
        EXPECT_LT(relative_error(measure_feel(c, f_Hz).displayed, feel_by_law(c, f_Hz)), bound)
            << f_Hz << " Hz, ratio " << damping_ratio << ", pressed " << is_pressed;
      }
    }
}

TEST(Feel, OfImplicitEulerIsOffInProportionToTheStep) {
  FeelCase c{.plan = feel_plans()[0], .integrator = "implicit-euler"};
  const auto error = [&](double step_s) {
    c.plan.step_s = step_s;
    return relative_error(measure_feel(c, 5).displayed, feel_by_law(c, 5));
  };
  const double coarse = error(1e-3), fine = error(5e-4);
  EXPECT_GT(coarse, 1e-3);
  EXPECT_NEAR(coarse / fine, 2, 0.2);
}

TEST(Feel, ForceIsLateByTheBus) {
  for (const FeelPlan& plan : feel_plans()) {
    const double expected = plan.has_buses ? plan.step_s * (1.5 + 0.5 * (plan.status_every - 1)) : 0;
    EXPECT_NEAR(delay_of(plan), expected, 0.02e-3) << plan.name;
  }
}

TEST(Feel, ThroughBusesIsTheLawWithItsDelay) {
  for (const FeelPlan& plan : feel_plans()) {
    if (!plan.has_buses || plan.count_m > 1e-6) continue;
    const FeelCase free{.plan = plan, .speed = 0.63};
    EXPECT_NEAR(measure_feel(free, 1).displayed.mass(), feel_by_law(free, 1).mass(), 2e-3)  // of 20 g
        << plan.name;
    const FeelCase pressed{.plan = plan, .is_pressed = true};
    for (const double f_Hz : {0.5, 1.0, 2.0})
      EXPECT_LT(relative_error(measure_feel(pressed, f_Hz).displayed, feel_by_law(pressed, f_Hz)), 0.01)
          << plan.name;
  }
}

/// Device, encoder, bus and drive are in the loop. The closed form is that of the device's mass and damping
/// beside the displayed tool.
TEST(Feel, TheHandFeelsTheDeviceBesideTheTool) {
  for (const bool is_pressed : {false, true}) {
    const FeelCase c{.plan = feel_plans()[1], .is_pressed = is_pressed};
    for (const double f_Hz : feel_frequencies(2)) {
      const Felt felt = measure_feel(c, f_Hz);
      const Impedance device = feel_of_device(f_Hz);
      const Impedance own{.f_Hz = f_Hz, .Z = felt.hand.Z - felt.displayed.Z};
      EXPECT_LT(relative_error(own, device), 2e-4) << f_Hz << " Hz, pressed " << is_pressed;
      const Impedance law{.f_Hz = f_Hz, .Z = device.Z + feel_by_law(c, f_Hz).Z};
      EXPECT_LT(relative_error(felt.hand, law), 0.07) << f_Hz << " Hz, pressed " << is_pressed;
    }
  }
}

/// In slow motion over coarse counts the estimated velocity is that of 7.5 periods ago. In implicit Euler it
/// changes the displayed mass by the lag times k_d g / k - g_d.
TEST(Feel, ALateVelocityChangesTheDisplayedMass) {
  using T = FeelTool;
  for (const double damping_ratio : {1.0, 1.4, 2.0}) {
    const FeelCase c{
        .plan = feel_plans().back(), .integrator = "implicit-euler", .damping_ratio = damping_ratio};
    const double g = damping_ratio * std::sqrt(T::k * T::mass), lag_s = 7.5 * c.plan.step_s;
    const double law = T::mass * T::k_d / T::k + lag_s * (T::k_d * g / T::k - T::g_d);
    EXPECT_NEAR(measure_feel(c, 0.5).displayed.mass(), law, 1.5e-3) << damping_ratio;
  }
}

TEST(Feel, CountsDominateOutsideOfTheBand) {
  const auto felt = [](double f_Hz, double sine_N, double ripple_N) {
    return Felt{.displayed = {.f_Hz = f_Hz, .Z = 0}, .hand = {}, .sine_N = sine_N, .ripple_N = ripple_N};
  };
  const CountBand inner = count_band({felt(0.1, 1, 10), felt(1, 10, 1), felt(10, 4, 1), felt(100, 1, 4)});
  EXPECT_NEAR(inner.lowest, std::sqrt(0.1), 1e-9);
  EXPECT_NEAR(inner.highest, std::sqrt(1e3), 1e-6);
  const CountBand all = count_band({felt(0.1, 2, 1), felt(1, 2, 1)});
  EXPECT_EQ(all.lowest, 0);
  EXPECT_TRUE(std::isinf(all.highest));
  EXPECT_EQ(count_band({felt(0.1, 1, 2), felt(1, 1, 2)}).highest, 0);
}

TEST(Feel, CountsDominateSlowFreeMotion) {
  const auto lowest = [](double count_m) {
    FeelCase c{.plan = feel_plans()[1]};
    c.plan.count_m = count_m;
    std::vector<Felt> felt;
    for (const double f_Hz : feel_frequencies(2)) felt.push_back(measure_feel(c, f_Hz));
    return count_band(felt).lowest;
  };
  EXPECT_EQ(lowest(1e-6), 0);
  const double fine = lowest(10e-6), coarse = lowest(100e-6);
  EXPECT_GT(fine, 0.1);
  EXPECT_LT(fine, 0.5);
  EXPECT_GT(coarse, 1);
  EXPECT_LT(coarse, 4);
}

TEST(Feel, FreeMotionHasNoDrag) {
  for (const FeelPlan& plan : feel_plans()) {
    if (plan.count_m > 1e-6) {
      EXPECT_LT(drag_of({.plan = plan}), 0.05) << plan.name;  // N
      continue;
    }
    for (const char* const integrator : {"implicit-euler", "tr-bdf2"})
      for (const double damping_ratio : {1.0, 2.0}) {
        const FeelCase c{.plan = plan, .integrator = integrator, .damping_ratio = damping_ratio};
        EXPECT_LT(drag_of(c), 0.05) << plan.name << ", " << integrator;
      }
  }
}

TEST(Feel, FrequenciesHaveWholePeriods) {
  const std::vector<double> frequencies = feel_frequencies(4);
  EXPECT_NEAR(frequencies.front(), 0.1, 1e-12);
  EXPECT_NEAR(frequencies.back(), 100, 1e-9);
  EXPECT_EQ(frequencies.size(), 13u);
  for (const double f_Hz : frequencies) EXPECT_NEAR(std::remainder(1 / f_Hz, 2e-3), 0, 1e-12);
}

}  // namespace
}  // namespace godobject::study::test_feel
