// Nets without anchors (57): their dampers act on the shape, and leave the rigid motion unchanged.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/net_energy.h"
#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_floating {
namespace {

/// Sums over the nodes.
struct Motion {
  Real m = 0, size = 0,
       own_energy = 0;  // size: bound of the angular momentum; own_energy: but for the rigid motion, J
  Vec3 c = Vec3::Zero(), P = Vec3::Zero(), L = Vec3::Zero();  // L about the centre c
};
template <class S>
Motion motion_of(const Running<S>& run) {
  Motion all;
  const auto each = [&](auto f) {
    for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
      f(run.par.net.nodes[n].m, run.x.net.nodes[n].p_W, run.x.net.nodes[n].v_W);
  };
  each([&](Real m, const Vec3& p, const Vec3& v) {
    all.m += m;
    all.c += m * p;
    all.P += m * v;
  });
  all.c /= all.m;
  Mat3 I = Mat3::Zero();
  each([&](Real m, const Vec3& p, const Vec3& v) {
    const Vec3 r = p - all.c;
    all.L += m * r.cross(v);
    all.size += m * r.norm() * v.norm();
    I += m * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  });
  const Vec3 w = I.inverse() * all.L;
  each([&](Real m, const Vec3& p, const Vec3& v) {
    all.own_energy += 0.5 * m * (v - all.P / all.m - w.cross(p - all.c)).squaredNorm();
  });
  return all;
}

/// A sheet, tube or tangle drawn at random, thrown, turning and stretched. T: settling time, s.
template <class S>
std::unique_ptr<Running<S>> thrown(unsigned seed, Real T, std::size_t carrier, int cap) {
  Random random(seed);
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.h = random.log_uniform(2e-4, 2e-3);
  par.gravity_W = 9.81 * random.direction();
  par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  place(run->x, 0, {.X_WB = {}, .V_WB = {}});
  run->in.devices[0] = {};
  const Real m = random.log_uniform(1e-4, 1e-3), k = random.log_uniform(20, 200);
  const Stuff stuff{.m = m, .k = k, .g = 0.02 * std::sqrt(k * m), .g_a = 8 * m / T, .carrier = carrier};
  const int shape = random.integer(0, 2);
  if (shape == 0) add_sheet(par, stuff, 5, 4, 0.01);
  if (shape == 1) add_tube(par, stuff, 6, 4, 0.01);
  if (shape == 2) add_tangle(random, par, stuff, 24, 0.01);
  for (std::size_t n = 0; n < par.net.num_nodes; ++n)  // dampers that are not in proportion to the masses
    par.net.nodes[n].g *= random.uniform(0.5, 1.5);
  put_in_order(par.net);
  par.net.max_iterations = cap;
  place_net(par.net, run->x);
  const Vec3 v = random.vector(), w = 5 * random.vector();
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    NodeState<S>& node = run->x.net.nodes[n];
    node.v_W += v + w.cross(node.p_W) + 0.1 * random.vector();
    node.p_W += 3e-4 * random.vector();
  }
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

/// Momenta are those that gravity gives, whatever the settling time and however few the iterations, and the
/// energy falls.
template <class S>
void keeps_its_motion() {
  Real linear = 0, angular = 0, rise = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    const int caps[] = {1, 2, 12};
    Random random(seed);
    auto run = thrown<S>(seed, random.log_uniform(5e-3, 0.5), world, caps[seed % 3]);
    const auto& par = run->par;
    ASSERT_EQ(par.net.num_rows, 1u);
    const Motion first = motion_of(*run);
    EnergyBalance<S> balance;
    balance.start(par, run->x);
    Real lowest = balance.balance();
    const Real energy = net_kinetic_energy(par, run->x) + net_spring_energy(par, run->x);
    for (int n = 0; n < 300; ++n) {
      run->step();
      ASSERT_EQ(run->out.fault, Fault::none);
      balance.observe(par, run->x, run->w, run->out);
      const Motion now = motion_of(*run);
      const Vec3 P = first.P + static_cast<Real>(run->x.tick) * par.h * first.m * par.gravity_W;
      linear = std::max(linear, (now.P - P).norm() / (first.P.norm() + P.norm()));
      angular = std::max(angular, (now.L - first.L).norm() / first.size);
      rise = std::max(rise, (balance.balance() - lowest) / energy);
      lowest = std::min(lowest, balance.balance());
    }
  }
  std::printf("%s: linear momentum within %.1e, angular within %.1e, energy rises by %.1e\n",
              S::Integrator::name, linear, angular, rise);
  EXPECT_LT(linear, 1e-11);
  EXPECT_LT(angular, 1e-11);
  EXPECT_LT(rise, 1e-3);
}
TEST(NetFloating, KeepsItsMotionAsAWhole) {
  keeps_its_motion<NetScene<ImplicitEuler>>();
  keeps_its_motion<NetScene<TrBdf2>>();
}

/// The residual of its non-rigid motion is 2 % squared after the settling time, up to varying dampers.
TEST(NetFloating, SettlesItsShape) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    constexpr Real T = 0.1;
    auto run = thrown<NetScene<TrBdf2>>(seed, T, world, 12);
    const Real first = motion_of(*run).own_energy + net_spring_energy(run->par, run->x);
    while (static_cast<Real>(run->x.tick) * run->par.h < 2 * T) run->step();
    EXPECT_LT(motion_of(*run).own_energy, 0.01 * first) << "seed " << seed;
  }
}

/// On a body that is held, without anchors: the net falls past it.
template <class S>
void falls_past_its_carrier() {
  for (unsigned seed = 0; seed < 6; ++seed) {
    auto run = thrown<S>(seed, 0.05, 0, 12);
    auto& par = run->par;
    par.bodies[0].coupling = {.k = 2000, .g = 20, .k_r = 1, .g_r = 0.02};
    par.bodies[0].device.rise = 0;
    engage_at(run->x, 0, {});
    run->in.devices[0].engaged = run->in.devices[0].valid = true;
    const Motion first = motion_of(*run);
    run->step(200);
    const Real t = 200 * par.h;
    EXPECT_LT((motion_of(*run).P - first.P - t * first.m * par.gravity_W).norm(), 0.01 * t * first.m * 9.81)
        << "seed " << seed;
  }
}
TEST(NetFloating, FallsPastABodyThatDoesNotHoldIt) {
  falls_past_its_carrier<NetScene<ImplicitEuler>>();
  falls_past_its_carrier<NetScene<TrBdf2>>();
}

/// A swab of the world, attached to a tool that a hand leads at a constant speed: the hand bears none of it.
template <class S>
Real drag_on_the_hand() {
  Real most = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    Random random(seed);
    auto run = std::make_unique<Running<S>>();
    auto& par = run->par;
    const Vec3 v = 0.5 * random.direction();
    par.bodies[0].body = rigid_body(0.05, Mat3(2e-5 * Mat3::Identity()));
    par.bodies[0].coupling = {.k = 500, .g = 7, .k_r = 1, .g_r = 0.01};
    par.bodies[0].device.rise = 0;
    place(run->x, 0, {.X_WB = {}, .V_WB = {.w = Vec3::Zero(), .v = v}});
    const Real m = 1e-3;
    add_tube(par, {.m = m, .k = 100, .g = 0.2, .g_a = 8 * m / 0.2}, 6, 4, 0.01);
    place_net(par.net, run->x);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) run->x.net.nodes[n].v_W = v;
    for (std::uint32_t n = 0; n < 6; ++n) attach(par, run->x, n, 0, 300, 0.5);
    EXPECT_EQ(validate(par), Invalid::nothing);
    const auto target = [&](Real t) {
      return Target{.X_WD = {.p = t * v}, .V_WD = {.w = Vec3::Zero(), .v = v}};
    };
    engage_at(run->x, 0, target(0));
    while (run->x.tick < 500) {
      run->in.devices[0].target = target(static_cast<Real>(run->x.tick + 1) * par.h);
      run->in.devices[0].engaged = run->in.devices[0].valid = true;
      run->step();
      EXPECT_EQ(run->out.fault, Fault::none);
    }
    most = std::max(most, coupling_at(par, run->x, 0).F_WB.f.norm());
  }
  std::printf("%s: %.1e N\n", S::Integrator::name, most);
  return most;
}
TEST(NetFloating, DoesNotDragTheHand) {
  EXPECT_LT(drag_on_the_hand<AttachedNetScene<ImplicitEuler>>(), 1e-6);
  EXPECT_LT(drag_on_the_hand<AttachedNetScene<TrBdf2>>(), 1e-6);
}

/// Anchors that pull, on one node or on all, hold a net: dampers then act against the world, as before.
TEST(NetFloating, IsNotANetThatIsHeld) {
  for (const bool all : {false, true}) {
    auto run = std::make_unique<Running<NetScene<TrBdf2>>>();
    auto& par = run->par;
    add_sheet(par, {.m = 1e-3, .k = 100, .k_a = all ? 10.0 : 0.0, .g_a = 0.04}, 4, 4, 0.01);
    par.net.nodes[5].k = 10;
    add_sheet(par, {.m = 1e-3, .k = 100, .g_a = 0.04}, 3, 3, 0.01);
    ASSERT_EQ(par.net.num_rows, 2u);
    EXPECT_FALSE(floats(par.net, par.net.rows[0]));
    EXPECT_TRUE(floats(par.net, par.net.rows[1]));
    EXPECT_EQ(par.net.rows[1].first, 16u);
    EXPECT_EQ(par.net.rows[1].end, 25u);
    par.net.nodes[20].k = 10;  // an anchor that is set after put_in_order() counts
    EXPECT_FALSE(floats(par.net, par.net.rows[1]));
  }
}

}  // namespace
}  // namespace godobject::test_net_floating
