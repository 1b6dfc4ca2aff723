// Bodies that begin inside each other come apart, slowly.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/box_overlap.h"
#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_touching_overlap {
namespace {

template <class I>
using Pair = Pile<FewBodies<I>>;

struct Separation {
  Real fastest = 0;  // a point of either, m/s
  Real depth = 0;    // in the end, m
};

/// The bodies of the pair left to themselves for two seconds.
template <class I>
Separation release(Pair<I>& pair) {
  Separation separation;
  for (int n = 0; n < 2 / pair.par.h; ++n) {
    pair.step();
    if (any(pair.out.fault)) return {.fastest = std::numeric_limits<Real>::infinity()};
    separation.fastest = std::max(separation.fastest, pair.fastest());
  }
  separation.depth = pair.out.contacts.deepest;
  return separation;
}

/// Returns the motion of two bricks, the second turned and shifted against the first.
template <class I>
Separation separated_bricks(const Vec3& shift, const Vec3& turn, const ContactLaw& law, Real h) {
  const auto pair = std::make_unique<Pair<I>>();
  pair->par.h = h;
  set_law(pair->par, law);
  const Quat q = exp_so3(Vec3(0.3, -0.2, 0.5));  // no axis of the world is special
  pair->add_brick({.X_WB = {.p = Vec3::Zero(), .q = q}, .V_WB = {}});
  pair->add_brick({.X_WB = {.p = q * shift, .q = q * exp_so3(turn)}, .V_WB = {}});
  return release(*pair);
}

void expect_apart(const Separation& separation) {
  EXPECT_LT(separation.fastest, 1);
  EXPECT_LT(separation.depth, 1e-5);
}

template <class I>
class TouchingOverlap : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(TouchingOverlap, BothIntegrators);

constexpr std::array stiffness{1e3, 2e4, 1e6};
constexpr std::array steps{2.5e-4, 1e-3, 5e-3};

TYPED_TEST(TouchingOverlap, BallsPart) {
  constexpr Real radius = 0.01;
  for (const Real k : stiffness)
    for (const Real h : steps)
      for (const Real ratio : {1.0, 1000.0}) {
        SCOPED_TRACE(::testing::Message() << "k " << k << ", h " << h << ", masses 1 to " << ratio);
        const auto pair = std::make_unique<Pair<TypeParam>>();
        pair->par.h = h;
        set_law(pair->par, law_of(k, 0.4));
        pair->add_ball({}, brick_mass, radius);
        pair->add_ball({.X_WB = at(Vec3(0.6, 0, 0.8) * radius), .V_WB = {}}, ratio * brick_mass, radius);
        expect_apart(release(*pair));
        EXPECT_GT((pair->p(0) - pair->p(1)).norm(), 2 * radius - 1e-5);
      }
}

/// Bodies of seven spheres, without shapes.
TYPED_TEST(TouchingOverlap, ClustersOfSpheresPart) {
  constexpr Real radius = 0.005;
  for (const Real k : stiffness)
    for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0.4, 0.3, -0.7)}) {
      SCOPED_TRACE(::testing::Message() << "k " << k << ", turned " << turn.norm());
      const auto pair = std::make_unique<Pair<TypeParam>>();
      set_law(pair->par, law_of(k, 0.4));
      for (std::size_t i = 0; i < 2; ++i) {
        pair->add(solid_ball(brick_mass, 0.01), {.X_WB = at(i * Vec3(0.01, 0.001, 0), i * turn), .V_WB = {}});
        add_sphere(pair->par, i, Vec3::Zero(), radius);
        for (int axis = 0; axis < 3; ++axis)
          for (const Real side : {-0.005, 0.005}) add_sphere(pair->par, i, side * Vec3::Unit(axis), radius);
      }
      expect_apart(release(*pair));
      EXPECT_GT((pair->p(0) - pair->p(1)).norm(), 0.015);
    }
}

TYPED_TEST(TouchingOverlap, BricksShiftedAndTurnedPart) {
  Random random(4);
  Real fastest = 0, deepest = 0;
  for (int n = 0; n < 120; ++n) {
    // half of the brick's size off in one direction, up to an eighth in the others
    Vec3 shift = brick_half.cwiseProduct(
        Vec3(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25)));
    shift[n % 3] = brick_half[n % 3];
    const Vec3 turn = random.uniform(0, 1.5) * random.direction();
    const Real k = stiffness[static_cast<std::size_t>(n / 3) % 3],
               h = steps[static_cast<std::size_t>(n / 9) % 3];
    SCOPED_TRACE(::testing::Message() << "case " << n << ", k " << k << ", h " << h);
    const Separation separation = separated_bricks<TypeParam>(shift, turn, law_of(k, 0.4), h);
    expect_apart(separation);
    fastest = std::max(fastest, separation.fastest);
    deepest = std::max(deepest, separation.depth);
  }
  std::printf("%s: bricks part at %.3f m/s at most, %.1e m left\n", TypeParam::name, fastest, deepest);
}

/// Spheres at opposite corners are pushed in opposite directions.
TYPED_TEST(TouchingOverlap, AlignedBricksPart) {
  for (int axis = 0; axis < 3; ++axis)
    for (const Real k : stiffness) {
      SCOPED_TRACE(::testing::Message() << "along axis " << axis << ", k " << k);
      const Vec3 shift = brick_half[axis] * Vec3::Unit(axis);
      expect_apart(separated_bricks<TypeParam>(shift, Vec3::Zero(), law_of(k, 0.4), 1e-3));
    }
}

#ifdef NDEBUG
constexpr unsigned num_sunk = 1200;
#else
constexpr unsigned num_sunk = 12;  // builds with assertions and sanitizers take a hundred times as long
#endif

/// Boxes whose centres are up to 15 mm apart, turned at random. More than half inside each other, also
/// crosswise, without a corner of one in the other.
TYPED_TEST(TouchingOverlap, SunkBoxesPart) {
  Real fastest = 0;
  for (unsigned seed = 0; seed < num_sunk; ++seed) {
    Random random(seed);
    const auto drawn = [&]() { return random.log_uniform(0.005, 0.03); };
    const auto half = [&](bool flat) {
      const Real x = drawn(), y = drawn(), z = drawn();
      return flat ? Vec3(0.02, 0.02, 0.01) : Vec3(x, y, z);
    };
    const Vec3 half_a = half(seed % 2 == 0), half_b = seed % 4 < 2 ? half_a : half(false);
    const auto pair = std::make_unique<Pair<TypeParam>>();
    pair->par.h = steps[static_cast<std::size_t>(random.integer(0, 2))];
    set_law(pair->par, law_of(stiffness[static_cast<std::size_t>(random.integer(0, 2))], 0.7, 0.3, 0.1));
    const Vec3 off = 0.005 * random.integer(0, 3) * random.direction();
    const Quat q_a = random.rotation(), q_b = random.rotation();
    add_cornered_brick(*pair, {.X_WB = {.p = Vec3::Zero(), .q = q_a}, .V_WB = {}}, 0.1, half_a, 5e-4);
    add_cornered_brick(*pair, {.X_WB = {.p = off, .q = q_b}, .V_WB = {}}, seed % 8 == 7 ? 10 : 0.1, half_b,
                       5e-4);
    for (int n = 0; n < 5 / pair->par.h; ++n) {
      pair->step();
      ASSERT_FALSE(any(pair->out.fault));
      fastest = std::max(fastest, pair->fastest());
      if (n % 100 == 99 && boxes_overlap(pair->at(0).X_WB, half_a, pair->at(1).X_WB, half_b) < 0) break;
    }
    EXPECT_LT(boxes_overlap(pair->at(0).X_WB, half_a, pair->at(1).X_WB, half_b), 3e-4) << "seed " << seed;
  }
  EXPECT_LT(fastest, 1);
  std::printf("%s: %u sunk pairs part at %.3f m/s at most\n", TypeParam::name, num_sunk, fastest);
}

}  // namespace
}  // namespace godobject::test_touching_overlap
