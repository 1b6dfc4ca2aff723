// How a violation of the joints is taken back, and how much of it a motion leaves, by stabilisation.
#include <iostream>
#include <vector>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/usual_scene.h"
#include "tests/support/stabilisation.h"

namespace godobject::test_stabilisation {
namespace {

template <class Stabilisation, class I = ImplicitEuler>
using StabilisedGrasper = GrasperTool<I, TreeJoints<None, None, Stabilisation>>;

/// Steps until the joints are apart by more than 1 m or 1 rad, or `limit`.
template <class Tool>
int steps_to_divergence(Tool tool, int limit) {
  for (int n = 1; n <= limit; ++n) {
    tool.follow();
    const Drift d = tool.drift();
    if (any(tool.out.fault) || !(d.m < 1 && d.rad < 1)) return n;
  }
  return limit;
}

/// Row 2 of the table: (5) with the old state, positions advanced by the new velocity.
TEST(Stabilisation, BaumgarteOnTheOldStateDivergesAtEveryStiffness) {
  for (int decade = 0; decade <= 10; ++decade) {
    const StabilisedGrasper<BaumgarteDiverging> tool({.stiffness = std::pow(10, decade)});
    EXPECT_LT(steps_to_divergence(tool, 1000), 100) << "stiffness 1e" << decade;
  }
}

/// Violations after each step of a grasper at rest whose trocar hangs 1 cm beside the origin.
template <class Stabilisation, class I = ImplicitEuler>
std::vector<Real> pulled_together(int steps) {
  StabilisedGrasper<Stabilisation, I> tool({.motion = GrasperMotion::at_rest()});
  const Vec3 apart_W(6e-3, 0, 8e-3);
  for (std::size_t i = 0; i < 4; ++i) tool.x.bodies[i].x.X_WB.p += apart_W;
  std::vector<Real> e{1};
  for (int n = 0; n < steps; ++n) {
    tool.step();
    e.push_back(violation(tool.par, tool.x, trocar).v.dot(apart_W) / apart_W.squaredNorm());
  }
  return e;
}

/// Eigenvalues of the step from (g, h g') to the next: 1/2 twice.
TEST(Stabilisation, BaumgarteOnTheNewStateHalvesTheError) {
  const std::vector<Real> e = pulled_together<BaumgarteImplicit>(40);
  // e_n = (1 + c n) / 2^n: e_2 - e_1 + e_0 / 4 = 0
  for (std::size_t n = 2; n < 15; ++n) EXPECT_NEAR(e[n], e[n - 1] - e[n - 2] / 4, 1e-4 * e[n - 2]) << n;
  for (std::size_t n = 2; n < 15; ++n) EXPECT_GT(e[n], 0) << n;
  EXPECT_LT(e[40], 1e-9);
}

/// Eigenvalues -1.618 and 0.618.
TEST(Stabilisation, BaumgarteOnTheOldStateOvershootsMoreAndMore) {
  const std::vector<Real> e = pulled_together<BaumgarteDiverging>(6);
  EXPECT_NEAR(e[1], 0, 1e-9);
  for (std::size_t n = 2; n < e.size(); ++n)
    EXPECT_NEAR(e[n], -e[n - 1] + e[n - 2], 1e-2 * std::abs(e[n - 1]) + 1e-9) << n;
}

TEST(Stabilisation, AtBaseAndAtPredictionAreDeadBeat) {
  EXPECT_NEAR(pulled_together<AtBase>(1)[1], 0, 1e-9);
  EXPECT_NEAR(pulled_together<AtPrediction>(1)[1], 0, 1e-9);
}

template <class Stabilisation, class I = ImplicitEuler>
Drift drift_in_motion(const char* name, Real stiffness) {
  StabilisedGrasper<Stabilisation, I> tool({.stiffness = stiffness});
  Drift all;
  for (int n = 0; n < 3000; ++n) {
    tool.follow();
    EXPECT_FALSE(any(tool.out.fault));
    all = worst(all, tool.drift());
  }
  std::cout << name << ", " << I::name << ", " << stiffness << " N/m: " << all.m << " m " << all.rad
            << " rad\n";
  return all;
}

/// At 1 kHz. Linearised at the start of the stage, the error is the square of h V; at the prediction, the
/// square of the prediction's error.
TEST(Stabilisation, DriftInMotion) {
  for (const Real stiffness : {1e3, 1e5, 1e7}) {
    EXPECT_LT((drift_in_motion<BaumgarteImplicit>("(5) on the new state", stiffness).m), 3e-5);
    EXPECT_LT((drift_in_motion<AtBase>("velocity level, base", stiffness).m), 3e-5);
    EXPECT_LT((drift_in_motion<AtPrediction>("velocity level, prediction", stiffness).m), 3e-8);
  }
}

}  // namespace
}  // namespace godobject::test_stabilisation
