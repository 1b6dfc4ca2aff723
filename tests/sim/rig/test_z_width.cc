// The Z-width map at the places that docs/theory/passivity.md publishes.
#include <gtest/gtest.h>

#include "tests/support/z_width.h"

namespace godobject::test_z_width {
namespace {

TEST(ZWidth, WallsOfThePublishedPlaces) {
  for (const ZWidthPlace& place : z_width_places()) {
    const ZWidthRow row = z_width_row(place);
    const auto at = testing::Message() << place.damping << " N s/m, delay " << place.delay << ", count "
                                       << place.count << " m, " << place.period_s << " s";
    EXPECT_LE(row.spring, 2 * place.colgate()) << at;
    EXPECT_GE(row.controlled, 200e3) << at;
    EXPECT_EQ(row.controlled == z_width_end_N_per_m, place.period_s < 0.5e-3) << at;
    EXPECT_EQ(row.laws.front(), row.spring) << at;  // the proxy is the sampled spring
    EXPECT_GE(row.laws.back(), 1.5 * row.spring) << at;
  }
}

/// At 4 kHz the controller stays on while the device presses, and its law does not depend on the stiffness.
TEST(ZWidth, WithoutEndTheDisplayedForceNoLongerDependsOnTheStiffness) {
  SampledWall wall = ZWidthPlace{.damping = 2, .period_s = 2.5e-4}.wall();
  const auto run = [&](double stiffness) {
    wall.stiffness = stiffness;
    return run_wall(wall, 3, [](double) { return 2.0; });
  };
  const WallRun last = run(z_width_end_N_per_m), beyond = run(1e3 * z_width_end_N_per_m);
  for (const WallRun& of : {last, beyond}) {
    EXPECT_EQ(of.given_J, 0);
    EXPECT_NEAR(of.mean_force, -2, 0.02);
    EXPECT_LT(of.ripple, 4);  // N, pressed with 2
  }
  EXPECT_NEAR(beyond.ripple / last.ripple, 1, 1e-3);
}

}  // namespace
}  // namespace godobject::test_z_width
