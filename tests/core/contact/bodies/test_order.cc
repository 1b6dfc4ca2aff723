// The order of both integrators among bodies that touch, where nothing hits, slips or comes apart.
#include <gtest/gtest.h>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_touching_order {
namespace {

constexpr Real duration = 0.128;  // s

template <class I>
using Tower = FewBodies<I>;

template <class I>
struct JointedTower : Tower<I> {
  using Joints = TreeJoints<>;
};

/// A turn about two axes, and a shift: where the device has the upper brick at time t. It begins at rest.
Pose device_at(Real t, const Vec3& start) {
  const Real s = 1 - std::cos(2 * pi * 6 * t);
  return at(start + Vec3(2e-4, 1e-4, -1e-4) * s, Vec3(0.01, 0.02, 0.03) * s);
}

/// Three bricks on each other, on ground so soft that the steps resolve their sway; the hand sways the upper
/// one. jointed: the middle one is on a hinge of the lower one, which lies in its plane.
template <class S, bool jointed>
std::vector<Vec3> swayed(Real h) {
  auto pile = std::make_unique<Pile<S>>();
  auto& par = pile->par;
  par.h = h;
  pile->add_floor();
  set_law(par, {.k = 60, .c = 0.05, .mu = 10, .k_t = 60, .c_t = 0.05});
  const Real height = 2 * brick_half.z();
  for (int i = 0; i < 3; ++i) {
    // pressed by their weight on six spheres each
    const Real sunk = (3 - i) * brick_mass * earth_gravity / (6 * 60);
    const Real below = i == 0 ? 0 : pile->p(static_cast<std::size_t>(i - 1)).z() + height / 2;
    pile->add_brick({.X_WB = at(Vec3(0, 0, below + height / 2 - sunk)), .V_WB = {}});
  }
  if constexpr (jointed) {
    auto& joint = par.bodies[1].joint;
    joint.kind = JointKind::hinge;
    joint.parent = 0;
    const Real apart = pile->p(1).z() - pile->p(0).z();
    const Quat about_y = turn_from_z(Vec3::UnitY());
    joint.P = {.p = Vec3(0, 0, apart / 2), .R = about_y.toRotationMatrix()};
    joint.C = {.p = Vec3(0, 0, -apart / 2), .R = about_y.toRotationMatrix()};
  }
  const Vec3 start = pile->p(2);
  pile->hold_at(2, device_at(0, start), {.k = 40, .g = 0.3, .k_r = 4e-3, .g_r = 2e-5});
  for (long n = 1; n <= std::lround(duration / h); ++n) {
    const Real t = static_cast<Real>(n) * h, dt = 1e-6;
    const Pose now = device_at(t, start), after = device_at(t + dt, start);
    pile->in.devices[2].target.X_WD = now;
    const Eigen::AngleAxis<Real> turn(after.q * now.q.conjugate());
    pile->in.devices[2].target.V_WD = {.w = turn.axis() * (turn.angle() / dt), .v = (after.p - now.p) / dt};
    pile->step();
    EXPECT_EQ(pile->out.fault, Fault::none);
  }
  return pile->positions();
}

Real difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  Real most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

/// Errors at 1, 1/2, 1/4 ms against TR-BDF2 at 1/64 ms; the order from the last two.
template <template <class> class S, class I, bool jointed>
Real order(const std::vector<Vec3>& exact) {
  std::vector<Real> errors;
  for (const Real h : {1e-3, 5e-4, 2.5e-4}) errors.push_back(difference(swayed<S<I>, jointed>(h), exact));
  const Real order = std::log2(errors[1] / errors[2]);
  std::printf("%s%s: %.1e, %.1e, %.1e m, order %.2f\n", I::name, jointed ? " on a joint" : "", errors[0],
              errors[1], errors[2], order);
  return order;
}

TEST(TouchingOrder, OfFreeBodies) {
  const std::vector<Vec3> exact = swayed<Tower<TrBdf2>, false>(1e-3 / 64);
  EXPECT_GT((order<Tower, ImplicitEuler, false>(exact)), 0.9);
  EXPECT_GT((order<Tower, TrBdf2, false>(exact)), 1.8);
}

TEST(TouchingOrder, OfBodiesOnJoints) {
  const std::vector<Vec3> exact = swayed<JointedTower<TrBdf2>, true>(1e-3 / 64);
  EXPECT_GT((order<JointedTower, ImplicitEuler, true>(exact)), 0.9);
  EXPECT_GT((order<JointedTower, TrBdf2, true>(exact)), 1.8);
}

}  // namespace
}  // namespace godobject::test_touching_order
