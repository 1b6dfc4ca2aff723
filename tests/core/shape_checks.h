// Properties of all shapes, checked on random points.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "core/shape/list.h"
#include "tests/core/one_body.h"

namespace godobject {

inline constexpr Real all = std::numeric_limits<Real>::infinity();

inline Vec3 point_in(Random& random, const Vec3& low, const Vec3& high) {
  const Real x = random.uniform(low.x(), high.x()), y = random.uniform(low.y(), high.y());
  return {x, y, random.uniform(low.z(), high.z())};
}

/// n is a unit vector, p - distance n is on the surface, the distance is 1-Lipschitz and where n does not
/// jump its gradient is n. Points are drawn from a box in the shape's frame that reaches well in and out;
/// `reach` is to cover it.
inline void check_distance_field(const ShapeParams& par, const Vec3& low, const Vec3& high, Real reach,
                                 int num_points) {
  Random random(7);
  const Real step = 1e-6;
  int inside = 0, smooth = 0;
  for (int i = 0; i < num_points; ++i) {
    const Vec3 p_W = par.X_WS.p + to_world(par.X_WS.q, point_in(random, low, high));
    const SurfacePoint s = nearest(par, p_W, reach);
    inside += s.distance < 0;
    ASSERT_NEAR(s.n.norm(), 1, 1e-13);
    ASSERT_NEAR(nearest(par, p_W - s.distance * s.n, reach).distance, 0, 1e-12) << p_W.transpose();

    const Vec3 other = p_W + random.log_uniform(1e-6, 1) * random.direction();
    const Real change = nearest(par, other, reach).distance - s.distance;
    ASSERT_LE(std::abs(change), (other - p_W).norm() + 1e-12) << p_W.transpose() << " " << other.transpose();

    for (int k = 0; k < 3; ++k) {
      const Vec3 d = step * Vec3::Unit(k);
      const SurfacePoint before = nearest(par, p_W - d, reach), after = nearest(par, p_W + d, reach);
      if ((after.n - before.n).norm() > 1e-3) continue;  // the medial axis, or a very near edge
      ++smooth;
      ASSERT_NEAR((after.distance - before.distance) / (2 * step), s.n[k], 2e-3) << p_W.transpose();
    }
  }
  EXPECT_GT(inside, num_points / 20);
  EXPECT_GT(smooth, 2 * num_points);
}

/// A position with NaN or infinity in any place must not look like a contact, nor like none. A distant one,
/// whose square overflows, must look like none.
inline void check_not_finite(const ShapeParams& par) {
  EXPECT_GE(nearest(par, {1e200, -1e200, 1e200}, 0.1).distance, 0.1);
  for (const Real bad : {std::numeric_limits<Real>::quiet_NaN(), all, -all}) {
    for (int k = 0; k < 3; ++k) {
      Vec3 p = Vec3::Constant(0.1);
      p[k] = bad;
      EXPECT_TRUE(std::isnan(nearest(par, p, 0.1).distance)) << bad << " " << k;
      ShapeParams lost = par;
      lost.X_WS.p[k] = bad;
      EXPECT_TRUE(std::isnan(nearest(lost, Vec3::Constant(0.1), 0.1).distance)) << bad << " " << k;
    }
  }
}

/// At nearest features that meet: a unit normal that leads to the surface.
inline void check_special_points(const ShapeParams& par, const std::vector<Vec3>& points_S) {
  for (const Vec3& p_S : points_S) {
    const Vec3 p_W = par.X_WS.p + to_world(par.X_WS.q, p_S);
    const SurfacePoint s = nearest(par, p_W, all);
    EXPECT_NEAR(s.n.norm(), 1, 1e-13) << p_S.transpose();
    EXPECT_NEAR(nearest(par, p_W - s.distance * s.n, all).distance, 0, 1e-12) << p_S.transpose();
  }
}

}  // namespace godobject
