// Scene S2 of the measured peers: ten spheres in a row, pressed 2 cm into a plane and dragged over it.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_pressed_tool {
namespace {

constexpr Real radius = 0.02, contact_k = 2e5;
constexpr int num_spheres = 10;

/// A value and its rate.
struct Moved {
  Real x = 0, v = 0;
};
Moved eased_swing(Real u, Real amplitude, Real frequency) {
  const Real e = std::min(Real(1), std::max(Real(0), u));
  const Real s = e * e * (3 - 2 * e), s_dot = u > 0 && u < 1 ? 6 * e * (1 - e) : 0, w = 2 * pi * frequency;
  return {amplitude * s * std::sin(w * u), amplitude * (s_dot * std::sin(w * u) + s * w * std::cos(w * u))};
}

Target target_at(Real t) {
  const Real e = std::min(Real(1), t), u = t - 1.5;
  const Moved x = eased_swing(u, 0.10, 0.5), y = eased_swing(u, 0.08, 0.3), yaw = eased_swing(u, 0.5, 0.4);
  Target target;
  target.X_WD.p = Vec3(x.x, y.x, 0.07 * (1 - e * e * (3 - 2 * e)));
  target.X_WD.q = exp_so3(Vec3(0, 0, yaw.x)) * exp_so3(Vec3(0, pi / 2, 0));
  target.V_WD = {.w = Vec3(0, 0, yaw.v), .v = Vec3(x.v, y.v, -0.07 * 6 * e * (1 - e))};
  return target;
}

template <class I>
Running<OneTool<I>> pressed_tool(Real k) {
  Running<OneTool<I>> run;
  auto& par = run.par;
  par.bodies[0].body = rigid_body(0.1, Vec3(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal());
  par.bodies[0].coupling = spring(par.bodies[0].body, k, 1e-3 * k);
  par.bodies[0].device.rise = 0;
  for (int i = 0; i < num_spheres; ++i) add_sphere(par, 0, Vec3(0, 0, -0.09 + 0.02 * i), radius);
  add_plane(par);
  set_law(par, {.k = contact_k, .c = 200, .mu = 0.3, .k_t = 2e5, .c_t = 200});
  EXPECT_EQ(validate(par), Invalid::nothing);
  place(run.x, 0, {.X_WB = target_at(0).X_WD, .V_WB = target_at(0).V_WD});
  engage_at(run.x, 0, target_at(0));
  return run;
}

/// Result of a run of 10 s, from 3 s on.
struct Steady {
  Real least = 1, most = 0;     // depth, m
  Real jitter = 0;              // rms of its change in a step, m
  Real residual = 0, load = 0;  // worst, N
};

template <class I>
Steady press_and_drag(Real k) {
  auto run = pressed_tool<I>(k);
  Steady s;
  Real last = 0;
  int n = 0, counted = 0;
  for (; n < 10000; ++n) {
    const Target target = target_at((n + 1) * run.par.h);
    run.device().target = target;
    run.step();
    EXPECT_FALSE(any(run.out.fault));
    const Real depth = radius - run.body().X_WB.p.z();
    if (n >= 1500 && !(depth > 0)) ADD_FAILURE() << "ejected in step " << n;
    if (n >= 3000) {
      EXPECT_EQ(run.out.contacts.num_contacts, num_spheres) << "step " << n;
      s.least = std::min(s.least, depth);
      s.most = std::max(s.most, depth);
      s.jitter += (depth - last) * (depth - last);
      s.residual = std::max(s.residual, run.out.contacts.residual);
      s.load = std::max(s.load, run.out.bodies[0].contact.F_W.f.norm());
      ++counted;
    }
    last = depth;
  }
  s.jitter = std::sqrt(s.jitter / counted);
  return s;
}

template <class I>
class PressedTool : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(PressedTool, BothIntegrators);

TYPED_TEST(PressedTool, StaysWhereItsSpringsBalance) {
  for (const Real k : {1e3, 1e4, 1e5, 1e6}) {
    const Steady s = press_and_drag<TypeParam>(k);
    const Real balance = k * radius / (k + num_spheres * contact_k);
    std::printf("%-14s k %.0e: depth %.6e to %.6e m (balance %.6e), jitter %.1e m, residual %.1e of %.1e N\n",
                TypeParam::name, k, s.least, s.most, balance, s.jitter, s.residual, s.load);
    EXPECT_NEAR(s.least, balance, 0.01 * balance) << k;
    EXPECT_NEAR(s.most, balance, 0.01 * balance) << k;
    EXPECT_LT(s.jitter, 1e-8) << k;
    EXPECT_LT(s.residual, 1e-5 * s.load) << k;
    EXPECT_GT(s.load, 0.9 * contact_k * num_spheres * balance) << k;
  }
}

}  // namespace
}  // namespace godobject::test_pressed_tool
