// Stability map of couplings: its four classes, and the limit of the explicit coupling, against theory.
#include <gtest/gtest.h>

#include "tests/study/stability_study.h"

namespace godobject::study::test_stability_study {
namespace {

StabilityCell cell_at(double wh, double damping) {
  StabilityCell cell{.k = 1000, .h = 0, .damping = damping, .inertia_ratio = 1};
  cell.h = 1;
  cell.h = wh / cell.wh();
  return cell;
}

TEST(StabilityStudy, ExplicitCouplingFailsAboveItsLimit) {
  for (const double damping : {0.0, 0.2, 1.4, 2.0})
    for (const double factor : {1.1, 3.0, 100.0})
      EXPECT_EQ(classify(explicit_name, cell_at(factor * explicit_limit(damping), damping)).stability,
                Stability::failed)
          << damping << ' ' << factor;
}

TEST(StabilityStudy, MeasuredExplicitLimitIsTheTheorys) {
  for (const double damping : {0.0, 0.2, 1.4, 2.0})
    EXPECT_NEAR(measured_explicit_limit(damping), explicit_limit(damping), 1e-3) << damping;
}

TEST(StabilityStudy, AssignsTheFourClasses) {
  const double limit = explicit_limit(1.4);
  EXPECT_EQ(classify(explicit_name, cell_at(1.2 * limit, 1.4)).stability, Stability::failed);
  EXPECT_EQ(classify(explicit_name, cell_at(0.01 * limit, 1.4)).stability, Stability::stable);
  // Undamped, the explicit scheme's energy oscillates by about wh / 2 and stays bounded.
  const StabilityResult swinging = classify(explicit_name, cell_at(0.1, 0));
  EXPECT_EQ(swinging.stability, Stability::energy_gaining);
  EXPECT_NEAR(swinging.rise, 0.1, 0.05);
  EXPECT_EQ(classify("implicit-euler", cell_at(1e-3, 0)).stability, Stability::stable);
  EXPECT_EQ(classify("implicit-euler", cell_at(1, 0)).stability, Stability::dissipative);
}

TEST(StabilityStudy, ImplicitEulerLosesWhatItsTheorySays) {
  // One step from rest: the energy falls to 1 / (1 + (wh)^2) of the initial one, the exact energy stays.
  const double wh = 10;
  EXPECT_NEAR(classify("implicit-euler", cell_at(wh, 0)).loss, 1 - 1 / (1 + wh * wh), 1e-9);
}

}  // namespace
}  // namespace godobject::study::test_stability_study
