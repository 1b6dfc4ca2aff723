// A follower of first order, without mass, beside the god-object (3), which has one, at equal coupling and
// contact. Explicit contact forces make the difference; implicit ones hold both.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_first_order_follower {
namespace {

constexpr Real h = 1e-3, m = 0.1, k = 1000;  // s, kg, N/m: of the coupling
const Real g = 1.4 * std::sqrt(k * m);       // N s/m, at the least damping ratio of the paper

/// True if 1 um of penetration fades away within 2000 steps. The wall pushes with the force at the start of
/// the step.
bool is_stable(bool has_mass, Real k_wall) {
  Real x = 1e-6, v = 0;
  for (int n = 0; n < 2000 && std::abs(x) < 1; ++n) {
    const Real f = -(k + k_wall) * x;
    if (has_mass) v += h * (f - g * v) / m;
    else v = f / g;
    x += h * v;
  }
  return std::abs(x) < 1e-6;
}

/// Returns the stiffness of the stiffest wall on which the follower is stable, N/m.
Real stiffest_wall(bool has_mass) {
  Real least = 1, most = 1e8;
  while (most > 1.0001 * least) {
    const Real middle = std::sqrt(least * most);
    (is_stable(has_mass, middle) ? least : most) = middle;
  }
  return least;
}

TEST(FirstOrderFollower, LosesToSecondOrderOnAnExplicitWall) {
  const Real first = stiffest_wall(false), second = stiffest_wall(true);
  EXPECT_NEAR(first, 2 * g / h - k, 0.01 * first);
  EXPECT_NEAR(second, (4 - 2 * h * g / m) * m / (h * h) - k, 0.01 * second);
  EXPECT_GT(second, 13 * first);
}

/// The core has no follower without mass; one of 1e-9 kg is moved by 1 kN/m as if it had none. The target is
/// 10 mm below the wall.
template <class I>
void expect_rest_on_a_hard_wall() {
  constexpr Real k_wall = 1e6, depth = 0.01, radius = 0.005;  // N/m, m
  Running<OneTool<I>> run;
  auto& par = run.par;
  par.h = h;
  par.bodies[0].body = rigid_body(1e-9, Mat3(1e-14 * Mat3::Identity()));
  par.bodies[0].device.rise = 0;
  par.bodies[0].coupling = {.k = k, .g = g, .k_r = 0.1, .g_r = 1e-3};
  add_sphere(par, 0, Vec3::Zero(), radius);
  add_plane(par);
  set_law(par, {.k = k_wall});
  place(run.x, 0, {.X_WB = {.p = Vec3(0, 0, 0.02)}, .V_WB = {}});
  hold_at(run, {.p = Vec3(0, 0, radius - depth)});
  ASSERT_EQ(validate(par), Invalid::nothing);
  run.step(2000);
  EXPECT_EQ(run.out.fault, Fault::none);
  const Real penetration = radius - run.body().X_WB.p.z();
  EXPECT_NEAR(penetration, depth * k / (k + k_wall), 1e-3 * penetration) << I::name;
  EXPECT_LT(run.body().v_W.norm(), 1e-9) << I::name;
}

TEST(FirstOrderFollower, RestsOnAHardWallWithImplicitContacts) {
  expect_rest_on_a_hard_wall<ImplicitEuler>();
  expect_rest_on_a_hard_wall<TrBdf2>();
}

}  // namespace
}  // namespace godobject::test_first_order_follower
