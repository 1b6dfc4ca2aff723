#include "tests/core/shape_checks.h"

namespace godobject::test_shape_height_field {
namespace {

/// Rough ground of 8 by 6 points, 0.25 m apart: 1.75 m by 1.25 m, heights within 0.2 m of zero.
struct Ground {
  std::vector<Real> height;
  HeightField field;
  ShapeParams par{.kind = ShapeKind::height_field};

  explicit Ground(Real roughness = 0.2, const Pose& X_WS = {}) : height(48) {
    Random random(5);
    for (Real& z : height) z = random.uniform(-roughness, roughness);
    field = {.height = height, .columns = 8, .rows = 6, .spacing = 0.25};
    par.X_WS = X_WS;
    par.height_field = &field;
  }
  Ground(const Ground&) = delete;

  std::vector<Corners> triangles() const {
    std::vector<Corners> all_of_them;
    for (std::uint32_t j = 0; j + 1 < field.rows; ++j)
      for (std::uint32_t i = 0; i + 1 < field.columns; ++i)
        for (const bool upper : {false, true}) all_of_them.push_back(cell_triangle(field, i, j, upper));
    return all_of_them;
  }
};

const Vec3 low(-0.4, -0.4, -0.6), high(2.15, 1.65, 0.6);

/// Distance to a triangle by trying its points: within 1 / n of its longest edge.
Real sampled_triangle(const Corners& t, const Vec3& p, int n) {
  Real best_sq = all;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j)
      best_sq = std::min(best_sq, (p - (t[0] + (i * (t[1] - t[0]) + j * (t[2] - t[0])) / n)).squaredNorm());
  return std::sqrt(best_sq);
}

TEST(Triangle, NearestPointMatchesSamples) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const Corners t{random.vector(), random.vector(), random.vector()};
    const Vec3 p = 2 * random.vector();
    const TrianglePoint q = nearest_on_triangle(t, upward_normal(t), p);
    const int n = 200;
    const Real longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
    const Real sampled = sampled_triangle(t, p, n), d = std::sqrt(q.distance_sq);
    EXPECT_LE(d, sampled + 1e-12);
    EXPECT_GE(d, sampled - longest / n);
    EXPECT_NEAR((p - q.p).norm(), d, 1e-12);
  }
}

TEST(HeightField, IsADistanceField) {
  const Ground ground(0.2, {.p = Vec3(0.1, 0.2, 0.3), .q = Random(4).rotation()});
  check_distance_field(ground.par, low, high, all, 2000);
}

TEST(HeightField, MatchesEveryTriangleAndWall) {
  const Ground ground;
  const std::vector<Corners> triangles = ground.triangles();
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = point_in(random, low, high);
    Real expected = all;
    for (const Corners& t : triangles)
      expected = std::min(expected, nearest_on_triangle(t, upward_normal(t), p).distance_sq);
    expected = std::sqrt(expected);
    // The walls by samples along the border, 0.5 mm apart, that reach down without end.
    for (int k = 0; k <= 3500; ++k) {
      const Real u = 0.5e-3 * k, v = std::min(u, 1.25);
      for (const Vec3& q : {Vec3(u, 0, 0), Vec3(u, 1.25, 0), Vec3(0, v, 0), Vec3(1.75, v, 0)}) {
        const Real z = std::min(p.z(), surface_height(ground.field, q.x(), q.y()));
        expected = std::min(expected, (p - Vec3(q.x(), q.y(), z)).norm());
      }
    }
    const SurfacePoint s = nearest(ground.par, p, all);
    EXPECT_LE(std::abs(s.distance), expected + 1e-12) << p.transpose();
    EXPECT_GE(std::abs(s.distance), expected - 0.5e-3) << p.transpose();
    const bool over = p.x() >= 0 && p.x() <= 1.75 && p.y() >= 0 && p.y() <= 1.25;
    EXPECT_EQ(s.distance < 0, over && p.z() < surface_height(ground.field, p.x(), p.y()));
  }
}

/// The most triangles a query within `reach` (m) looks at.
Real max_visits(const HeightField& field, Real reach) {
  const auto along = [&](std::uint32_t points) {
    return std::min(2 * reach / field.spacing + 2, Real(points) - 1);
  };
  return 2 * along(field.columns) * along(field.rows);
}

TEST(HeightField, ReachBoundsTheWorkAndNotTheAnswer) {
  const Ground ground;
  Random random(6);
  Real most = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = point_in(random, low, high);
    const Real reach = random.uniform(0, 0.5);
    std::uint32_t visited = 0;
    const SurfacePoint s = HeightFieldShape::nearest(ground.field, p, reach, visited);
    const SurfacePoint exact = nearest(ground.par, p, all);
    EXPECT_LE(visited, max_visits(ground.field, reach));
    most = std::max(most, visited / max_visits(ground.field, reach));
    if (std::abs(exact.distance) < reach) {
      EXPECT_EQ(s.distance, exact.distance);
      EXPECT_EQ(s.n, exact.n);
    } else {
      EXPECT_GE(std::abs(s.distance), reach - 1e-15);
      EXPECT_EQ(s.distance < 0, exact.distance < 0);
    }
  }
  EXPECT_GT(most, 0.5);
}

TEST(HeightField, FlatIsABoxWithoutBottom) {
  const Ground ground(0);
  Random random(6);
  const Vec3 b(0.875, 0.625, 10);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = point_in(random, low, high);
    const ShapeParams box{
        .kind = ShapeKind::box, .X_WS = {.p = Vec3(b.x(), b.y(), -b.z())}, .half_extents = b};
    const SurfacePoint s = nearest(ground.par, p, all), expected = nearest(box, p, all);
    EXPECT_NEAR(s.distance, expected.distance, 1e-14);
    EXPECT_LE((s.n - expected.n).norm(), 1e-12) << p.transpose();
  }
}

TEST(HeightField, HasNormalsOnItsPointsEdgesAndBorder) {
  const Ground ground;
  std::vector<Vec3> points;
  for (std::uint32_t j = 0; j < 6; ++j) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      const Vec3 p = ground.field.point(i, j);
      points.insert(points.end(), {p, p + Vec3(0, 0, 0.3), p - Vec3(0, 0, 0.3)});
      if (i > 0 && j > 0) points.push_back(Real(0.5) * (p + ground.field.point(i - 1, j - 1)));
    }
  }
  check_special_points(ground.par, points);
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_GT(nearest(ground.par, ground.field.point(i, 3), 0).n.z(), 0);
  check_not_finite(ground.par);
}

TEST(HeightField, RoundingDoesNotTurnTheNormalOnAnEdge) {
  const Ground ground;
  Random random(9);
  for (const Corners& t : ground.triangles()) {
    for (std::size_t i = 0; i < 150; ++i) {
      const Vec3 a = t[i % 3], b = t[(i + 1) % 3];
      const Vec3 p = a + random.uniform(0, 1) * (b - a) + 1e-16 * random.direction();
      const bool inside = p.x() > 1e-12 && p.x() < 1.75 - 1e-12 && p.y() > 1e-12 && p.y() < 1.25 - 1e-12;
      if (!inside) continue;  // beside a wall
      EXPECT_GT(nearest(ground.par, p, 0.1).n.z(), 0.2) << p.transpose();
    }
  }
}

TEST(HeightField, SizesAreChecked) {
  Ground ground;
  EXPECT_TRUE(is_valid(ground.par));
  const HeightField good = ground.field;
  ground.field.rows = 7;
  EXPECT_FALSE(is_valid(ground.par));
  ground.field.rows = 1;
  EXPECT_FALSE(is_valid(ground.par));
  ground.field = good;
  ground.field.spacing = 0;
  EXPECT_FALSE(is_valid(ground.par));
  ground.field = good;
  ground.height[5] = all;
  EXPECT_FALSE(is_valid(ground.par));
}

}  // namespace
}  // namespace godobject::test_shape_height_field
