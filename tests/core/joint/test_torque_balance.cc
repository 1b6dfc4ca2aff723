// Reported wrenches of joints are means over the step. Torques on a body sum to the change of its angular
// momentum R I w to the integrator's order. Levers of joints are those at mid-step (TR-BDF2) or at the end
// (implicit Euler). No lever makes the sum exact for both bodies of a joint, because it turns in the step.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/joint/random_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_torque_balance {
namespace {

constexpr Real size = 0.1;  // m

/// A tree of one to six bodies on the world, in gravity, with turns of about 1 rad/s.
template <class I>
std::unique_ptr<Running<Articulated<I>>> tree(unsigned seed, Real h) {
  Random random(seed);
  auto run = std::make_unique<Running<Articulated<I>>>();
  auto& par = run->par;
  par.h = h;
  par.gravity_W = 9.81 * random.direction();
  par.num_bodies = static_cast<std::size_t>(random.integer(1, 6));
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    add_random_body(par, i, size, random);
    run->in.devices[i].engaged = false;
  }
  // without contacts a free root does not keep R I w (64)
  if (par.bodies[0].joint.kind == JointKind::free) par.bodies[0].joint.kind = JointKind::ball;
  place_randomly(par, run->x, size, 1, random);
  return run;
}

template <class S>
Vec3 angular_momentum_of(const Params<S>& par, const State<S>& x, std::size_t i) {
  return x.bodies[i].x.X_WB.q * Vec3(par.bodies[i].body.I_B * x.bodies[i].x.w_B);
}
/// Returns the vector from the centre of mass of body b to the anchor of joint i.
template <class S>
Vec3 lever(const Params<S>& par, const State<S>& x, std::size_t i, std::size_t b) {
  const Pose& X = x.bodies[i].x.X_WB;
  return X.p + X.q * par.bodies[i].joint.C.p - x.bodies[b].x.X_WB.p;
}

/// Largest missing torque of a body, and largest torque of a hinge about its axis, of the largest torque.
struct Missing {
  Real torque = 0, about_axis = 0;
};

/// Compares the steps of 50 ms but the first three, in which TR-BDF2 starts.
template <class I>
Missing missing(unsigned seed, Real h) {
  const auto run = tree<I>(seed, h);
  const auto& par = run->par;
  const Real of_end = I::order == 2 ? 0.5 : 1;
  Missing most;
  Real largest = 0;
  for (long n = 0; n < std::lround(0.05 / h); ++n) {
    const auto before = run->x;
    run->step();
    EXPECT_FALSE(any(run->out.fault));
    const auto between = [&](const Vec3& start, const Vec3& end) -> Vec3 {
      return (1 - of_end) * start + of_end * end;
    };
    std::array<Vec3, 8> T;
    for (std::size_t i = 0; i < par.num_bodies; ++i)
      T[i] = (angular_momentum_of(par, run->x, i) - angular_momentum_of(par, before, i)) / h;
    Real about_axis = 0;
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      const JointParams& joint = par.bodies[i].joint;
      const Wrench& F = run->out.bodies[i].joint.F_C;
      for (const std::size_t b : {i, joint.parent}) {
        if (b == world) continue;
        const Vec3 r = between(lever(par, before, i, b), lever(par, run->x, i, b));
        T[b] += (b == i ? -1 : 1) * (F.tau + r.cross(F.f));
        largest = std::max(largest, F.tau.norm() + r.norm() * F.f.norm());
      }
      if (joint.kind != JointKind::hinge) continue;
      const Vec3 axis = joint.C.R.col(2);
      const auto in_world = [&](const auto& x) -> Vec3 { return x.bodies[i].x.X_WB.q * axis; };
      about_axis = std::max(about_axis, std::abs(F.tau.dot(between(in_world(before), in_world(run->x)))));
    }
    if (n < 3) continue;
    most.about_axis = std::max(most.about_axis, about_axis);
    for (std::size_t i = 0; i < par.num_bodies; ++i) most.torque = std::max(most.torque, T[i].norm());
  }
  return {.torque = most.torque / largest, .about_axis = most.about_axis / largest};
}

/// Returns the median over trees of missing torques, and the largest torque about an axis.
template <class I>
Missing over_trees(Real h) {
  constexpr unsigned trees = 60;
  std::vector<Real> torque;
  Missing all;
  for (unsigned seed = 1; seed <= trees; ++seed) {
    const Missing one = missing<I>(seed, h);
    torque.push_back(one.torque);
    all.about_axis = std::max(all.about_axis, one.about_axis);
  }
  const auto middle = torque.begin() + trees / 2;
  std::nth_element(torque.begin(), middle, torque.end());
  all.torque = *middle;
  std::printf("%s, %.2f ms: torques miss %.1e, worst tree %.1e, about axes of hinges %.1e\n", I::name,
              1e3 * h, all.torque, *std::max_element(torque.begin(), torque.end()), all.about_axis);
  return all;
}

template <class I>
void expect_order(Real least, Real most_missing) {
  const Missing coarse = over_trees<I>(4e-3), fine = over_trees<I>(1e-3);
  EXPECT_GT(std::log2(coarse.torque / fine.torque) / 2, least);
  EXPECT_GT(std::log2(coarse.about_axis / fine.about_axis) / 2, least);
  EXPECT_LT(fine.torque, most_missing);
}
TEST(TorqueBalance, OfJointsIsOfFirstOrderImplicitEuler) { expect_order<ImplicitEuler>(0.9, 2e-4); }
TEST(TorqueBalance, OfJointsIsOfSecondOrderTrBdf2) { expect_order<TrBdf2>(1.9, 1e-5); }

}  // namespace
}  // namespace godobject::test_torque_balance
