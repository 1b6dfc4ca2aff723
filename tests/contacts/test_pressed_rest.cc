// A body that a spring presses against obstacles comes to rest, whatever the stiffness, damping, step and press.
#include <gtest/gtest.h>

#include "tests/contacts/contact_scene.h"

namespace godobject::test_pressed_rest {
namespace {

constexpr Real rest = 1e-9;  // m/s

/// A box with a small sphere at each corner.
struct Box {
  Real m = 0.1, radius = 2e-4;
  Vec3 half = Vec3(0.02, 0.02, 0.01);
};

struct Press {
  Real h = 1e-3, k = 1e6, zeta = 1.4, mu = 0.3;  // the ratio is about the mass of the body
  Real k_coupling = 1e3;
  Vec3 target = Vec3(0, 0, -0.05);
};

template <class I>
using Pressed = Touching<I, 1, 8, PoseDevice, 2, 16>;

template <class I>
std::unique_ptr<Running<Pressed<I>>> pressed(const Box& box, const Press& press, const Pose& start) {
  auto run = std::make_unique<Running<Pressed<I>>>();
  auto& par = run->par;
  par.h = press.h;
  const Vec3 sq = box.half.cwiseProduct(box.half);
  const Vec3 I_B = box.m / 3 * Vec3(sq.y() + sq.z(), sq.z() + sq.x(), sq.x() + sq.y());
  par.bodies[0].body = rigid_body(box.m, I_B.asDiagonal());
  const Real k = press.k_coupling, k_r = 1e-3 * k;
  par.bodies[0].coupling = {.k = k,
                            .g = Real(2.8) * std::sqrt(k * box.m),
                            .k_r = k_r,
                            .g_r = Real(2.8) * std::sqrt(k_r * I_B.maxCoeff())};
  const Vec3 at = box.half - Vec3::Constant(box.radius);
  for (int i = 0; i < 8; ++i)
    add_sphere(par, 0, Vec3(i & 4 ? at.x() : -at.x(), i & 2 ? at.y() : -at.y(), i & 1 ? at.z() : -at.z()),
               box.radius);
  const Real c = 2 * press.zeta * std::sqrt(box.m * press.k);
  set_law(par, {.k = press.k, .c = c, .mu = press.mu, .k_t = press.k, .c_t = c});
  place(run->x, 0, {.X_WB = start, .V_WB = {}});
  hold_at(*run, {.p = press.target, .q = Quat::Identity()});
  return run;
}

/// The fastest that a point of the body moves over a number of steps, m/s.
template <class S>
Real fastest(Running<S>& run, int steps, Real lever) {
  Real most = 0;
  for (int i = 0; i < steps; ++i) {
    run.step();
    EXPECT_EQ(run.out.fault, Fault::none);
    const RigidBodyState& x = run.x.bodies[0].x;
    most = std::max(most, x.v_W.norm() + lever * x.w_B.norm());
  }
  return most;
}

template <class I>
class PressedRest : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(PressedRest, BothIntegrators);

TYPED_TEST(PressedRest, OnAPlane) {
  Random random(16);
  Real most = 0;
  for (int n = 0; n < 400; ++n) {
    const Box box{.m = random.log_uniform(3e-3, 1), .radius = random.log_uniform(1e-4, 3e-3)};
    const Press press{.h = random.log_uniform(1e-4, 5e-3),
                      .k = random.log_uniform(1e3, 1e9),
                      .zeta = n % 5 == 0 ? 0 : random.log_uniform(0.01, 3),
                      .mu = random.uniform(0, 1),
                      .k_coupling = random.log_uniform(1e2, 1e5),
                      .target = Vec3(0, 0, -random.uniform(0.01, 0.2))};
    const auto run =
        pressed<TypeParam>(box, press, {.p = Vec3(0, 0, random.uniform(0.011, 0.05)), .q = Quat::Identity()});
    add_plane(run->par);
    run->step(static_cast<int>(3 / press.h));
    const Real v = fastest(*run, 20, 0.03);
    most = std::max(most, v);
    EXPECT_LT(v, rest) << n << ": h " << press.h << ", m " << box.m << ", k " << press.k << ", zeta "
                       << press.zeta << ", mu " << press.mu << ", coupling " << press.k_coupling << ", "
                       << press.target.z();
  }
  std::printf("%s: %.1e m/s at most\n", TypeParam::name, most);
}

/// Between two planes at 60 degrees to the horizontal, tilted.
TYPED_TEST(PressedRest, InAWedge) {
  Random random(17);
  Real most = 0;
  for (int n = 0; n < 200; ++n) {
    const Box box{.m = random.log_uniform(0.01, 1), .radius = random.log_uniform(2e-4, 3e-3)};
    const Press press{.h = random.log_uniform(1e-4, 3e-3),
                      .k = random.log_uniform(1e4, 1e9),
                      .zeta = random.log_uniform(0.1, 3),
                      .mu = n % 2 == 0 ? 0 : random.uniform(0, 1),
                      .k_coupling = random.log_uniform(1e3, 1e5),
                      .target = Vec3(0, 0, -random.uniform(0.01, 0.1))};
    const Real tilt = random.uniform(-0.3, 0.3);
    const Pose start{.p = Vec3(0, 0, 0.08), .q = Quat(Eigen::AngleAxis<Real>(tilt, Vec3::UnitY()))};
    const auto run = pressed<TypeParam>(box, press, start);
    for (const Real side : {-1, 1})
      add_plane(run->par,
                {.p = Vec3::Zero(), .q = Quat(Eigen::AngleAxis<Real>(side * pi / 3, Vec3::UnitY()))});
    run->step(static_cast<int>(4 / press.h));
    const Real v = fastest(*run, 20, 0.03);
    most = std::max(most, v);
    EXPECT_LT(v, rest) << n << ": h " << press.h << ", m " << box.m << ", k " << press.k << ", zeta "
                       << press.zeta << ", mu " << press.mu << ", coupling " << press.k_coupling << ", "
                       << press.target.z();
  }
  std::printf("%s: %.1e m/s at most\n", TypeParam::name, most);
}

}  // namespace
}  // namespace godobject::test_pressed_rest
