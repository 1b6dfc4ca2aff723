// The felt impedance against its law in continuous time, and the line between motion and force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/study/feel/feel.h"

namespace godobject::study::test_feel {
namespace {

double relative_error(const Felt& felt, const Felt& law) {
  return std::abs(felt.Z - law.Z) / std::abs(law.Z);
}

TEST(Feel, WithoutBusesIsThatOfTheLaw) {
  for (const double damping_ratio : {1.0, 1.4, 2.0})
    for (const bool is_pressed : {false, true}) {
      FeelCase c{.plan = feel_plans()[0], .damping_ratio = damping_ratio, .is_pressed = is_pressed};
      for (const double f_Hz : feel_frequencies(2)) {
        const double bound = f_Hz > 40 ? 0.03 : 2e-3;
        EXPECT_LT(relative_error(measure_feel(c, f_Hz), feel_by_law(c, f_Hz)), bound)
            << f_Hz << " Hz, ratio " << damping_ratio << ", pressed " << is_pressed;
      }
    }
}

TEST(Feel, OfImplicitEulerIsOffInProportionToTheStep) {
  FeelCase c{.plan = feel_plans()[0], .integrator = "implicit-euler"};
  const auto error = [&](double step_s) {
    c.plan.step_s = step_s;
    return relative_error(measure_feel(c, 5), feel_by_law(c, 5));
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
    if (!plan.has_buses) continue;
    const FeelCase free{.plan = plan};
    EXPECT_NEAR(measure_feel(free, 1).mass(), feel_by_law(free, 1).mass(), 2e-3) << plan.name;  // of 20 g
    const FeelCase pressed{.plan = plan, .is_pressed = true};
    for (const double f_Hz : {0.5, 1.0, 2.0})
      EXPECT_LT(relative_error(measure_feel(pressed, f_Hz), feel_by_law(pressed, f_Hz)), 0.01) << plan.name;
  }
}

TEST(Feel, FreeMotionHasNoDrag) {
  for (const FeelPlan& plan : feel_plans())
    for (const char* const integrator : {"implicit-euler", "tr-bdf2"})
      for (const double damping_ratio : {1.0, 2.0}) {
        const FeelCase c{.plan = plan, .integrator = integrator, .damping_ratio = damping_ratio};
        EXPECT_LT(drag_of(c), 0.05) << plan.name << ", " << integrator;  // N
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
