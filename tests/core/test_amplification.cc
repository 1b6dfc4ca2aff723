// A step is the matrix R(h A) of its scheme for a body on its coupling spring, x'' = -(k x + g x') / m
// (docs/theory/amplification.md).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/core/one_body.h"

namespace godobject::test_amplification {
namespace {

using Matrix = Eigen::Matrix<Real, 2, 2>;

/// Returns h A for the state (x, h x').
Matrix scaled_rate(Real m, Real k, Real g, Real h) {
  return (Matrix() << 0, 1, -h * h * k / m, -h * g / m).finished();
}

Matrix amplification(ImplicitEuler, const Matrix& hA) { return (Matrix::Identity() - hA).inverse(); }

Matrix amplification(TrBdf2, const Matrix& hA) {
  const Real d = 1 - 1 / std::sqrt(Real(2)), b = std::sqrt(Real(2)) / 4;
  const Matrix one = Matrix::Identity(), solve = (one - d * hA).inverse();
  return solve * (one + b * hA + b * hA * solve * (one + d * hA));
}

struct Mode {
  Real m, k, g;
};

Mode drawn(Random& random) {
  const Real m = random.log_uniform(1e-3, 10), k = random.log_uniform(1, 1e10);
  return {.m = m, .k = k, .g = random.uniform(0, 3) * std::sqrt(m * k)};
}

template <class Integrator>
class Amplification : public ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Amplification, Integrators, );

TYPED_TEST(Amplification, OfAStepIsThatOfTheScheme) {
  Random random(1);
  int steps_of_the_scheme = 0;
  for (int i = 0; i < 2000; ++i) {
    const Mode mode = drawn(random);
    Running<OneBody<TypeParam>> run;
    run.par.h = random.log_uniform(1e-5, 1e-2);
    run.constants().body = rigid_body(mode.m, Mat3::Identity() * (mode.m * 1e-2));
    run.constants().coupling = {.k = mode.k, .g = mode.g, .k_r = 1, .g_r = 1};
    Start start;
    start.X_WB.p = Vec3(random.uniform(-1, 1), 0, 0);
    place(run.x, 0, start);
    engage_at(run.x, 0, {});
    run.device() = {.target = {}};
    const Matrix R = amplification(TypeParam(), scaled_rate(mode.m, mode.k, mode.g, run.par.h));
    run.step();  // TR-BDF2 starts itself
    for (int n = 0; n < 3; ++n) {
      const Eigen::Vector2d before(run.body().X_WB.p.x(), run.par.h * run.body().v_W.x());
      run.step();
      if (has(run.out.limited, Limited::first_order)) continue;
      ++steps_of_the_scheme;
      const Eigen::Vector2d after(run.body().X_WB.p.x(), run.par.h * run.body().v_W.x());
      // of a stiff mode rounding of the position is multiplied by h^2 k / m
      const Real rounding = 1e-14 * (1 + run.par.h * run.par.h * mode.k / mode.m);
      EXPECT_LT((after - R * before).norm(), (1e-11 + rounding) * before.norm() + 1e-300)
          << "m " << mode.m << " k " << mode.k << " g " << mode.g << " h " << run.par.h;
    }
  }
  EXPECT_GT(steps_of_the_scheme, 5900);
}

/// Neither scheme enlarges a mode, and both end one that is infinitely stiff.
TYPED_TEST(Amplification, IsAtMostOneAndVanishesForStiffModes) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Mode mode = drawn(random);
    const Real h = random.log_uniform(1e-6, 1);
    const Matrix R = amplification(TypeParam(), scaled_rate(mode.m, mode.k, mode.g, h));
    EXPECT_LE(R.eigenvalues().cwiseAbs().maxCoeff(), 1 + 1e-9);
  }
  const Matrix stiff = amplification(TypeParam(), scaled_rate(1, 1e14, 1.4e7, 1));
  EXPECT_LT(stiff.eigenvalues().cwiseAbs().maxCoeff(), 1e-5);
}

/// At h w = 0.1 without damping: the size of a mode after a step, and its phase against h w.
TEST(AmplificationOf, AnUndampedModeShrinksByTheOrderOfTheScheme) {
  const auto shrinks = [](auto integrator, Real hw) {
    return 1 - std::abs(amplification(integrator, scaled_rate(1, hw * hw, 0, 1)).eigenvalues()[0]);
  };
  EXPECT_NEAR(shrinks(ImplicitEuler(), 0.1), 0.1 * 0.1 / 2, 1e-4);
  EXPECT_NEAR(shrinks(ImplicitEuler(), 0.1) / shrinks(ImplicitEuler(), 0.05), 4, 0.1);
  EXPECT_NEAR(shrinks(TrBdf2(), 0.1), 0.0037e-4, 0.01e-6);
  EXPECT_NEAR(shrinks(TrBdf2(), 0.1) / shrinks(TrBdf2(), 0.05), 16, 0.5);
}

/// Stabilisation (5), g'' + (2/h) g' + g/h^2 = 0, as a map of (g, h g').
TEST(AmplificationOf, StabilisationDependsOnItsPairing) {
  const auto largest = [](const Matrix& map) { return map.eigenvalues().cwiseAbs().maxCoeff(); };
  const Matrix explicit_euler = (Matrix() << 1, 1, -1, 1 - 2).finished();
  // g+ = g + h g'+, h g'+ = h g' - 2 h g' - g
  const Matrix symplectic = (Matrix() << 1 - 1, 1 - 2, -1, 1 - 2).finished();
  // h g'+ = h g' - 2 h g'+ - g+: g'+ (1 + 2 + 1) = g' - g
  const Matrix at_the_end = (Matrix() << 1 - 0.25, 0.25, -0.25, 0.25).finished();
  EXPECT_LT(largest(explicit_euler), 1e-7);
  EXPECT_NEAR(largest(symplectic), (1 + std::sqrt(5.0)) / 2, 1e-12);
  EXPECT_NEAR(largest(at_the_end), 0.5, 1e-7);
}

}  // namespace
}  // namespace godobject::test_amplification
