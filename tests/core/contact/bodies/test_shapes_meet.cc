// Balls, capsules and boxes of bodies against those of the world and of other bodies, drawn overlapping or
// near. Depth and normal of their deepest contact against an independent nearest point.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/usual_scenes.h"
#include "tests/oracle/solids_apart.h"

namespace godobject::test_shapes_meet {
namespace {

#ifdef NDEBUG
constexpr unsigned draws = 1500;
#else
constexpr unsigned draws = 20;  // builds with assertions and sanitizers take a hundred times as long
#endif

constexpr std::array kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};

ShapeParams drawn_shape(ShapeKind kind, Random& random) {
  const auto length = [&] { return random.log_uniform(5e-3, 0.03); };
  ShapeParams shape{.kind = kind};
  if (kind == ShapeKind::box)
    for (Real& half : shape.half_extents) half = length();
  else shape.radius = length();
  if (kind == ShapeKind::capsule) shape.half_length = length();
  return shape;
}
oracle::RoundedBox solid_of(const ShapeParams& shape, const Pose& X_WS) {
  oracle::RoundedBox solid{
      .half = shape.half_extents, .radius = shape.radius, .R_W = X_WS.q.toRotationMatrix(), .p_W = X_WS.p};
  if (shape.kind == ShapeKind::capsule) solid.half = Vec3(0, 0, shape.half_length);
  return solid;
}

/// Two shapes, the second of the world or of a free body, with a drawn depth along a drawn direction.
template <class S>
struct Pair {
  Random random;
  ShapeParams a, b;
  Pose X_WA, X_WB;
  oracle::Overlap expected;
  std::unique_ptr<Pile<S>> pile = std::make_unique<Pile<S>>();

  Pair(unsigned seed, ShapeKind of_a, ShapeKind of_b, bool on_body, bool rounded) : random(seed) {
    a = drawn_shape(of_a, random);
    b = drawn_shape(of_b, random);
    X_WB = {.p = 0.1 * random.vector(), .q = random.rotation()};
    X_WA.q = random.rotation();
    const Vec3 way = random.direction();
    const Real depth = random.uniform(-0.2, 0.3) * std::min(half_thickness(a), half_thickness(b));
    Real near = 0, far = 0.3;
    for (int n = 0; n < 50; ++n) {
      const Real middle = (near + far) / 2;
      X_WA.p = X_WB.p + middle * way;
      expected = oracle::overlap(solid_of(a, X_WA), solid_of(b, X_WB));
      (expected.depth > depth ? near : far) = middle;
    }
    set_law(pile->par, {.k = 1e-6, .c = 0, .mu = 0, .k_t = 0, .c_t = 0});
    const auto add_body = [&](const ShapeParams& shape, const Pose& X) {
      const std::size_t i = pile->add(solid_ball(1, 0.05), {.X_WB = X, .V_WB = {}});
      for (std::uint32_t j = 0; rounded && j < num_points(shape.kind); ++j) {
        const ShapePoint point = point_of(shape, j, half_thickness(shape));
        add_sphere(pile->par, i, point.p_S, point.r);
      }
      pile->carry(i, shape);
    };
    if (!on_body) {
      pile->par.contacts.surfaces[pile->par.contacts.num_surfaces++] = {.shape = b};
      pile->par.contacts.surfaces[0].shape.X_WS = X_WB;
    }
    const bool b_first = on_body && random.integer(0, 1) == 1;
    if (b_first) add_body(b, X_WB);
    add_body(a, X_WA);
    if (on_body && !b_first) add_body(b, X_WB);
    n_off = b_first ? -1 : 1;
  }
  Real n_off = 1;
  bool is_parallel() const {
    const Vec3 z = Vec3::UnitZ();
    return a.kind == ShapeKind::capsule && b.kind == ShapeKind::capsule &&
           (X_WA.q * z).cross(X_WB.q * z).norm() < min_edge_sine;
  }

  /// Calls f(contact) for the contacts of a step, in which nothing moves.
  template <class F>
  void each_contact(F f) {
    EXPECT_EQ(validate(pile->par), Invalid::nothing);
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    const auto& near = pile->w.contacts.near;
    for (std::size_t i = 0; i < near.size; ++i) {
      if (i > 0) {
        EXPECT_LT(near.list[i - 1].key, near.list[i].key);
      }
      f(near.list[i]);
    }
  }
  /// Returns the contact's normal off shape b.
  Vec3 normal(const NearContact& at) const {
    const bool of_other = at.b < 8 && at.a > at.b;  // normals are off the touched body
    return (of_other ? -n_off : n_off) * at.n_W;
  }
};

/// True for two boxes. In each other they also have deeper contacts along other normals.
bool is_sharp(const ShapeParams& a, const ShapeParams& b) {
  return a.kind == ShapeKind::box && b.kind == ShapeKind::box;
}
/// Returns by how much corners of boxes are rounded, m: by their spheres, or balls that select faces.
Real rounding_of(const ShapeParams& a, const ShapeParams& b, bool rounded) {
  Real thinnest = std::min(half_thickness(a), half_thickness(b)), of_spheres = 0;
  for (const ShapeParams* shape : {&a, &b})
    if (shape->kind == ShapeKind::box) of_spheres = std::max(of_spheres, half_thickness(*shape));
  if (of_spheres == 0) return 1e-9;
  return 0.8 * corner_ball * (rounded ? of_spheres : thinnest);
}

template <class S>
void expect_pairs(bool on_body, bool rounded) {
  int overlaps = 0, compared = 0;
  for (const ShapeKind of_a : kinds)
    for (const ShapeKind of_b : kinds)
      for (unsigned seed = 0; seed < draws; ++seed) {
        Pair<S> pair(seed, of_a, of_b, on_body, rounded);
        const oracle::Overlap& expected = pair.expected;
        const Real rounding = rounding_of(pair.a, pair.b, rounded);
        Real deepest = -1, nearest = 1;
        pair.each_contact([&](const NearContact& at) {
          deepest = std::max(deepest, at.d);
          const Real off = (pair.normal(at) - expected.n).norm();
          const Real turn = rounding > 1e-6 ? 0.2 : 1e-6;
          if (off < turn) nearest = std::min(nearest, std::abs(at.d - expected.depth));
        });
        SCOPED_TRACE(::testing::Message()
                     << "shapes " << int(of_a) << " and " << int(of_b) << ", seed " << seed << ", depth "
                     << expected.depth << ", rounding " << rounding);
        if (expected.depth > rounding) {
          EXPECT_GT(deepest, 0) << "not found";
        }
        if (expected.depth < -1e-9) {
          EXPECT_LE(deepest, rounding) << "found apart";
        }
        overlaps += expected.depth > rounding ? 1 : 0;
        if (!expected.sure || !(expected.depth > rounding) || pair.is_parallel()) continue;
        EXPECT_LT(nearest, rounding);
        if (!is_sharp(pair.a, pair.b)) {
          EXPECT_NEAR(deepest, expected.depth, rounding);
        }
        ++compared;
        if (::testing::Test::HasFailure()) return;
      }
  std::printf("%d overlaps, %d compared\n", overlaps, compared);
  EXPECT_GT(overlaps, int(3 * draws));
}

template <class S>
struct ShapesMeet : ::testing::Test {};
using Scenes = ::testing::Types<FewBodies<ImplicitEuler>, FewBodies<TrBdf2>>;
TYPED_TEST_SUITE(ShapesMeet, Scenes);

TYPED_TEST(ShapesMeet, OnAnObstacle) { expect_pairs<TypeParam>(false, false); }
TYPED_TEST(ShapesMeet, OnAFreeBody) { expect_pairs<TypeParam>(true, false); }
TYPED_TEST(ShapesMeet, WithSpheresOnAnObstacle) { expect_pairs<TypeParam>(false, true); }
TYPED_TEST(ShapesMeet, WithSpheresOnAFreeBody) { expect_pairs<TypeParam>(true, true); }
TEST(ShapesMeetAlone, OnAnObstacle) { expect_pairs<OneTool<ImplicitEuler>>(false, false); }

}  // namespace
}  // namespace godobject::test_shapes_meet
