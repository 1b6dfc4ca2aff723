// A body pressed against obstacles by a spring comes to rest, for any stiffness, damping, step and force.
#include <gtest/gtest.h>

#include "tests/core/contact/pressed_box.h"
#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_pressed_rest {
namespace {

constexpr Real rest = 1e-9;  // m/s

template <class I>
class PressedRest : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(PressedRest, BothIntegrators);

TYPED_TEST(PressedRest, OnAPlane) {
  Random random(16);
  Real most = 0;
  for (int n = 0; n < 400; ++n) {
    const PressedBox box{.m = random.log_uniform(3e-3, 1), .radius = random.log_uniform(1e-4, 3e-3)};
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
    const PressedBox box{.m = random.log_uniform(0.01, 1), .radius = random.log_uniform(2e-4, 3e-3)};
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
