// Piles of bricks stand: towers, walls, heavy bricks on light ones, and as deep in each other as they weigh.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_touching_stacks {
namespace {

using Scene64 = TouchingBodies<ImplicitEuler, 64>;
using BrickPile = Pile<Scene64>;

#ifdef NDEBUG
constexpr Real standing = 60;  // s
#else
constexpr Real standing = 0.5;  // builds with assertions and sanitizers take a hundred times as long
#endif

/// `masses` from the bottom up.
std::unique_ptr<BrickPile> tower(const std::vector<Real>& masses, const ContactLaw& law = brick_law) {
  auto pile = std::make_unique<BrickPile>();
  pile->add_floor();
  set_law(pile->par, law);
  const Real height = 2 * brick_half.z();
  for (std::size_t i = 0; i < masses.size(); ++i)
    pile->add_brick({.X_WB = at(Vec3(0, 0, (static_cast<Real>(i) + 0.5) * height)), .V_WB = {}}, masses[i]);
  return pile;
}

/// By how much the top of a tower at rest is lower: on six spheres of the lowest, and twelve between two.
Real compression(const std::vector<Real>& masses, Real k) {
  Real load = 0, sum = 0;
  for (std::size_t i = masses.size(); i-- > 0;) {
    load += masses[i] * earth_gravity;
    sum += load / (k * (i == 0 ? 6 : 12));
  }
  return sum;
}

/// After it has settled.
void expect_to_stand(const char* name, BrickPile& pile) {
  ASSERT_TRUE(pile.run(1));
  const std::vector<Vec3> settled = pile.positions();
  Real drift = 0, residual = 0;
  for (int n = 0; n < 10; ++n) {
    ASSERT_TRUE(pile.run(standing / 10));
    drift = std::max(drift, pile.drift_since(settled));
    residual = std::max(residual, pile.out.contacts.residual);
  }
  std::printf("%s: drift %.1e m in %g s, kinetic energy %.1e J, residual %.1e N\n", name, drift, standing,
              pile.kinetic(), residual);
  EXPECT_LT(drift, 1e-4);
  EXPECT_LT(pile.kinetic(), 1e-9);
}

TEST(TouchingStacks, ATowerOfTwentyStandsForAMinute) {
  const std::vector<Real> masses(20, brick_mass);
  const auto pile = tower(masses);
  const Real top = pile->p(19).z();
  expect_to_stand("tower of 20", *pile);
  const Real expected = compression(masses, brick_law.k);
  EXPECT_NEAR(top - pile->p(19).z(), expected, 0.01 * expected);
}

/// Rows of eight and seven in running bond, and four on top: no end hangs over.
TEST(TouchingStacks, AWallOf64StandsForAMinute) {
  const auto pile = std::make_unique<BrickPile>();
  pile->add_floor();
  const Real pitch = 2 * brick_half.x() + 5e-4, height = 2 * brick_half.z();
  for (int row = 0; row < 9; ++row) {
    const int columns = row == 8 ? 4 : 8 - row % 2;
    for (int i = 0; i < columns; ++i)
      pile->add_brick(
          {.X_WB = at(Vec3((i - 0.5 * (columns - 1)) * pitch, 0, (row + 0.5) * height)), .V_WB = {}});
  }
  ASSERT_EQ(pile->par.num_bodies, 64u);
  const std::vector<Vec3> built = pile->positions();
  expect_to_stand("wall of 64", *pile);
  EXPECT_LT(pile->drift_since(built), 1e-4);
}

/// A brick of 1000 times the mass on `under` others.
void expect_to_bear(const char* name, std::size_t under) {
  std::vector<Real> masses(under, brick_mass);
  masses.push_back(1000 * brick_mass);
  const auto pile = tower(masses);
  const Real top = pile->p(under).z();
  expect_to_stand(name, *pile);
  const Real expected = compression(masses, brick_law.k);
  EXPECT_NEAR(top - pile->p(under).z(), expected, 0.01 * expected);
  EXPECT_LT(pile->p(under).head<2>().norm(), 1e-6);
}

TEST(TouchingStacks, ALightBrickBearsAHeavyOne) { expect_to_bear("1000 on 1", 1); }
TEST(TouchingStacks, FiveLightBricksBearAHeavyOne) { expect_to_bear("1000 on 1 1 1 1 1", 5); }

/// Stiff towers that begin exactly touching: any contact may be taken for open.
TEST(TouchingStacks, StandOnAnyStiffness) {
  for (const Real k : {1e4, 1e5, 1e6, 1e7, 1e8})
    for (const Real zeta : {0.1, 1.0}) {
      const std::vector<Real> masses(10, brick_mass);
      const auto pile = tower(masses, law_of(k, zeta));
      const Real top = pile->p(9).z(), expected = compression(masses, k);
      ASSERT_TRUE(pile->run(1)) << k;
      EXPECT_NEAR(top - pile->p(9).z(), expected, 0.01 * expected + 1e-12) << k << ", " << zeta;
      EXPECT_LT(pile->kinetic(), 1e-9) << k << ", " << zeta;
    }
}

}  // namespace
}  // namespace godobject::test_touching_stacks
