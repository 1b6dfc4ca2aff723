// Stretch (51) of a sphere that rolls on a plane and pivots.
#include <gtest/gtest.h>

#include "core/contact/anchors.h"
#include "tests/core/one_body.h"

namespace godobject::test_rolling {
namespace {

/// Returns the change of stretch over a time t, m, of a sphere that rolls on a plane without slip. The plane
/// is body b, or body a if is_turned_round. w_W: angular velocity, rad/s.
Real change(const Vec3& n_W, const Vec3& w_W, const Vec3& xi_W, Real radius, Real t, bool is_turned_round) {
  const ContactPlacesOf<Real> start{.p_a = radius * n_W};
  ContactPlacesOf<Real> end = start;
  end.p_a += t * w_W.cross(Vec3(radius * n_W));
  end.R_a = exp_so3(Vec3(t * w_W)).toRotationMatrix();
  const auto swapped = [](const ContactPlacesOf<Real>& at) {
    return ContactPlacesOf<Real>{.R_a = at.R_b, .R_b = at.R_a, .p_a = at.p_b, .p_b = at.p_a};
  };
  const Vec3 none = Vec3::Zero();
  const auto of = is_turned_round
                      ? stretch<Real>(anchored<Real>(swapped(start), none, -n_W, -xi_W, none), swapped(end),
                                      -n_W, -radius)
                      : stretch<Real>(anchored<Real>(start, none, n_W, xi_W, none), end, n_W, radius);
  EXPECT_NEAR(of.before_W.norm(), xi_W.norm(), 1e-15 * xi_W.norm());
  return of.change_W.norm();
}

TEST(Rolling, ChangesTheStretchByThirdOrderWhilePivoting) {
  Random random(1);
  Real worst = 0;
  for (int draw = 0; draw < 200; ++draw) {
    const Vec3 n = random.direction(), along = n.cross(random.direction()).normalized(),
               xi = 1e-6 * n.cross(random.direction()).normalized();
    const Real radius = random.log_uniform(1e-3, 0.1), pivot = random.uniform(-1, 1);
    const bool is_turned_round = draw % 2 == 1;
    const auto of = [&](Real t) {
      return change(n, along + pivot * n, xi, radius, t, is_turned_round) / radius;
    };
    EXPECT_LT(change(n, along, xi, radius, 0.1, is_turned_round), 1e-14 * radius);
    EXPECT_LT(of(0.1), 0.1 * 0.1 * 0.1 * std::abs(pivot));
    EXPECT_LT(of(0.01), 0.01 * 0.01 * 0.01 * std::abs(pivot) + 1e-14);
    worst = std::max(worst, of(0.01) / (0.01 * 0.01 * 0.5 * std::abs(pivot)));
  }
  std::printf("a sphere that pivots and rolls by 0.01 rad: change by %.1e of h^2 w_n w_t radius / 2\n",
              worst);
}

}  // namespace
}  // namespace godobject::test_rolling
