#include "tests/core/shape_checks.h"

namespace godobject::test_shapes {
namespace {

Pose some_pose(unsigned seed = 3) {
  Random random(seed);
  return {.p = Vec3(0.3, -0.2, 0.1), .q = random.rotation()};
}

ShapeParams box(const Vec3& half_extents, const Pose& X_WS = {}) {
  return {.kind = ShapeKind::box, .X_WS = X_WS, .half_extents = half_extents};
}
ShapeParams sphere(Real radius, const Pose& X_WS = {}) {
  return {.kind = ShapeKind::sphere, .X_WS = X_WS, .radius = radius};
}
ShapeParams capsule(Real radius, Real half_length, const Pose& X_WS = {}) {
  return {.kind = ShapeKind::capsule, .X_WS = X_WS, .radius = radius, .half_length = half_length};
}

constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
const Vec3 cube = Vec3::Ones();

TEST(Shapes, EveryKindIsADistanceField) {
  check_distance_field({.X_WS = some_pose()}, -cube, cube, 0, 2000);
  check_distance_field(sphere(0.7, some_pose()), -cube, cube, 0, 2000);
  check_distance_field(capsule(0.4, 0.6, some_pose()), -cube, cube, 0, 2000);
  check_distance_field(capsule(0.5, 0, some_pose()), -cube, cube, 0, 2000);
  check_distance_field(box({0.5, 0.7, 0.3}, some_pose()), -cube, cube, 0, 2000);
}

TEST(Shapes, PositionsThatAreNotFiniteGiveNoDistance) {
  check_not_finite({});
  check_not_finite(sphere(0.7));
  check_not_finite(capsule(0.4, 0.6));
  check_not_finite(box(cube));
  ShapeParams turned = sphere(0.7);
  turned.X_WS.q.x() = nan;
  EXPECT_TRUE(std::isnan(nearest(turned, cube, 0).distance));
}

TEST(Shapes, PlaneIsItsZ) {
  const ShapeParams par{.X_WS = some_pose()};
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p_S = random.vector();
    const SurfacePoint s = nearest(par, par.X_WS.p + to_world(par.X_WS.q, p_S), 0);
    EXPECT_NEAR(s.distance, p_S.z(), 1e-14);
    EXPECT_LE((s.n - par.X_WS.q.toRotationMatrix().col(2)).norm(), 1e-14);
  }
}

TEST(Shapes, SphereIsTheDistanceToItsCentre) {
  const ShapeParams par = sphere(0.7, some_pose());
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p_W = random.vector(), a = p_W - par.X_WS.p;
    const SurfacePoint s = nearest(par, p_W, 0);
    EXPECT_NEAR(s.distance, a.norm() - 0.7, 1e-14);
    EXPECT_LE((s.n - a.normalized()).norm(), 1e-13);
  }
}

TEST(Shapes, SphereHasANormalAtItsCentre) {
  const SurfacePoint s = nearest(sphere(0.7), Vec3::Zero(), 0);
  EXPECT_EQ(s.distance, -0.7);
  EXPECT_EQ(s.n, Vec3(Vec3::UnitZ()));
  check_special_points(sphere(0.7),
                       {Vec3::Zero(), Vec3(1e-200, 0, 0), Vec3(0, 1e-160, 1e-161), Vec3(0.7, 0, 0)});
}

TEST(Shapes, CapsuleMatchesSamplesOfItsAxis) {
  const ShapeParams par = capsule(0.4, 0.6, some_pose());
  const Vec3 axis = par.X_WS.q.toRotationMatrix().col(2);
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p_W = par.X_WS.p + random.vector();
    Real sampled = all;
    for (int k = -1000; k <= 1000; ++k)
      sampled = std::min(sampled, (p_W - par.X_WS.p - 0.6e-3 * k * axis).norm() - 0.4);
    const Real d = nearest(par, p_W, 0).distance;
    EXPECT_LE(d, sampled + 1e-14);
    EXPECT_GE(d, sampled - 0.6e-3);
  }
}

TEST(Shapes, CapsuleHasANormalOnItsAxis) {
  for (const Real z : {-0.6, -0.1, 0.0, 0.6}) {
    const SurfacePoint s = nearest(capsule(0.4, 0.6), {0, 0, z}, 0);
    EXPECT_EQ(s.distance, -0.4);
    EXPECT_EQ(s.n, Vec3(Vec3::UnitX()));
  }
  check_special_points(capsule(0.4, 0.6, some_pose()), {{0, 0, 0}, {0, 0, 0.6}, {0, 0, 1}, {0, 0.4, -0.6}});
}

/// Shortest way to a grid of points on the box's faces.
Real sampled_box_surface(const Vec3& b, const Vec3& p, int n) {
  Real nearest_sq = all;
  for (int k = 0; k < 3; ++k) {
    for (int i = -n; i <= n; ++i) {
      for (int j = -n; j <= n; ++j) {
        Vec3 q;
        q[(k + 1) % 3] = b[(k + 1) % 3] * i / n;
        q[(k + 2) % 3] = b[(k + 2) % 3] * j / n;
        for (const Real side : {-b[k], b[k]}) {
          q[k] = side;
          nearest_sq = std::min(nearest_sq, (p - q).squaredNorm());
        }
      }
    }
  }
  return std::sqrt(nearest_sq);
}

TEST(Shapes, BoxMatchesSamplesOfItsFaces) {
  const Vec3 b(0.5, 0.7, 0.3);
  Random random(1);
  const int n = 70;  // samples 0.01 m apart at most: none is farther than 0.0071 m from one
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = point_in(random, -cube, cube);
    const Real sampled = sampled_box_surface(b, p, n), d = nearest(box(b), p, 0).distance;
    EXPECT_LE(std::abs(d), sampled + 1e-14);
    EXPECT_GE(std::abs(d), sampled - 0.0071);
    EXPECT_EQ(d < 0, (p.cwiseAbs().array() < b.array()).all());
  }
}

TEST(Shapes, BoxResolvesTiesInOrder) {
  const SurfacePoint centre = nearest(box(cube), Vec3::Zero(), 0);
  EXPECT_EQ(centre.distance, -1);
  EXPECT_EQ(centre.n, Vec3(Vec3::UnitX()));
  EXPECT_EQ(nearest(box({0.5, 0.7, 0.3}), Vec3::Zero(), 0).n, Vec3(Vec3::UnitZ()));
  EXPECT_EQ(nearest(box(cube), {-0.5, 0.5, 0.5}, 0).n, Vec3(-Vec3::UnitX()));
  EXPECT_EQ(nearest(box(cube), {0.2, -0.5, 0.5}, 0).n, Vec3(-Vec3::UnitY()));
}

TEST(Shapes, BoxHasNormalsOnEdgesAndCorners) {
  const SurfacePoint corner = nearest(box(cube), cube, 0);
  EXPECT_EQ(corner.distance, 0);
  EXPECT_EQ(corner.n, Vec3(Vec3::UnitX()));
  const SurfacePoint off = nearest(box(cube), {1, 1.5, 1.5}, 0);
  EXPECT_NEAR(off.distance, std::sqrt(0.5), 1e-15);
  EXPECT_LE((off.n - Vec3(0, 1, 1).normalized()).norm(), 1e-15);
  const Real next = std::nextafter(1.0, 2.0);
  check_special_points(box(cube, some_pose()),
                       {{1, 1, 0}, {-1, 0.5, 1}, {next, 1, 1}, {next, next, -1}, {0, 0, 1}});
}

TEST(Shapes, DimensionsAreChecked) {
  EXPECT_TRUE(is_valid(ShapeParams{}));
  EXPECT_TRUE(is_valid(sphere(1)));
  EXPECT_TRUE(is_valid(capsule(1, 0)));
  EXPECT_TRUE(is_valid(box(cube)));
  for (const Real bad : {0.0, -1.0, nan, all}) {
    EXPECT_FALSE(is_valid(sphere(bad)));
    EXPECT_FALSE(is_valid(capsule(bad, 1)));
    EXPECT_FALSE(is_valid(box({1, bad, 1})));
    EXPECT_EQ(is_valid(capsule(1, bad)), bad == 0);
  }
  EXPECT_FALSE(is_valid(ShapeParams{.kind = ShapeKind::height_field}));
  EXPECT_FALSE(is_valid(ShapeParams{.kind = ShapeKind::mesh}));
  ShapeParams off;
  off.X_WS.q.w() = 0.9;
  EXPECT_FALSE(is_valid(off));
  off = {};
  off.X_WS.p.x() = nan;
  EXPECT_FALSE(is_valid(off));
}

}  // namespace
}  // namespace godobject::test_shapes
