// A body with its net in free flight. A step, also with iterations cut off early, conserves its momenta, and
// the reported residual bounds the error of its velocities.
#include <gtest/gtest.h>

#include "core/net_energy.h"
#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_momentum {
namespace {

/// Returns a tube of 48 nodes on a free body, its springs stretched, all flying, turning and moving at
/// random.
template <class S>
std::unique_ptr<Running<S>> in_flight(unsigned seed, Real k_a_ratio, int max_iterations) {
  Random random(seed);
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.bodies[0].body = rigid_body(0.02, random.inertia(Vec3(4e-6, 5e-6, 7e-6)));
  par.net.max_iterations = max_iterations;
  const Real k = random.log_uniform(30, 300), m = random.log_uniform(1e-4, 1e-3);
  Stuff stuff{.m = m, .k = k, .g = 0.1 * std::sqrt(k * m), .carrier = 0};
  stuff.k_a = k_a_ratio * k;
  stuff.g_a = 0.1 * std::sqrt(stuff.k_a * m);
  add_tube(par, stuff, 8, 6, 0.01);
  place(run->x, 0,
        {.X_WB = {.p = 0.1 * random.vector(), .q = random.rotation()},
         .V_WB = {.w = 5 * random.vector(), .v = random.vector()}});
  place_net(par.net, run->x);
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    run->x.net.nodes[n].p_W += 1e-3 * random.vector();
    run->x.net.nodes[n].v_W += 0.1 * random.vector();
  }
  run->in.devices[0] = {};
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

/// Momentum of body and nodes, about the origin, and a bound of its size.
struct Momentum {
  Vec3 P = Vec3::Zero(), L = Vec3::Zero();
  Real P_scale = 0, L_scale = 0;

  void add(Real m, const Vec3& p, const Vec3& v) {
    P += m * v;
    L += m * p.cross(v);
    P_scale += m * v.norm();
    L_scale += m * p.norm() * v.norm();
  }
};
template <class S>
Momentum momentum(const Running<S>& run) {
  Momentum sum;
  const RigidBodyState& body = run.x.bodies[0].x;
  sum.add(run.par.bodies[0].body.m, body.X_WB.p, body.v_W);
  const Vec3 spin = body.X_WB.q * (run.par.bodies[0].body.I_B * body.w_B);
  sum.L += spin;
  sum.L_scale += spin.norm();
  for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
    sum.add(run.par.net.nodes[n].m, run.x.net.nodes[n].p_W, run.x.net.nodes[n].v_W);
  return sum;
}

template <class S>
void solve_completely(Running<S>& run) {
  run.par.net.max_iterations = 5000;
  run.par.net.tolerance = 1e-15 / (run.par.h * run.par.h);
}

/// The largest misses of flights, of the momenta that there were at first.
struct Miss {
  Real linear = 0, angular = 0;
};
/// beside: adds parts to the scene that are independent of the flight.
template <class S, class Beside>
Miss misses(Beside beside) {
  Miss miss;
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const int cap : {1, 2, 12}) {
      auto run = in_flight<S>(seed, seed % 2 == 0 ? 0.1 : 0.01, cap);
      beside(*run);
      const Momentum first = momentum(*run);
      for (int n = 0; n < 500; ++n) {
        run->step();
        EXPECT_EQ(run->out.fault, Fault::none);
        const Momentum now = momentum(*run);
        miss.linear = std::max(miss.linear, (now.P - first.P).norm() / first.P_scale);
        miss.angular = std::max(miss.angular, (now.L - first.L).norm() / first.L_scale);
      }
    }
  }
  std::printf("%s: linear momentum within %.1e, angular momentum within %.1e of what they were\n",
              S::Integrator::name, miss.linear, miss.angular);
  return miss;
}
void expect_none(const Miss& miss) {
  EXPECT_LT(miss.linear, 1e-11);
  EXPECT_LT(miss.angular, 1e-11);
}

TEST(NetMomentum, IsKeptHoweverFewTheIterations) {
  const auto nothing = [](const auto&) {};
  expect_none(misses<NetScene<ImplicitEuler>>(nothing));
  expect_none(misses<NetScene<TrBdf2>>(nothing));
}

/// A pendulum that swings on a hinge, and a ball that lies on a plane.
template <class S>
void add_others(Running<S>& run) {
  auto& par = run.par;
  par.num_bodies = 3;
  par.gravity_W = Vec3::Zero();
  for (std::size_t i = 1; i < 3; ++i) {
    par.bodies[i].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
    run.in.devices[i] = {};
  }
  par.bodies[1].joint.kind = JointKind::hinge;
  par.bodies[1].joint.P.p = Vec3(5, 0, 0);
  par.bodies[1].joint.C.p = Vec3(0.1, 0, 0);
  place(run.x, 1, {.X_WB = {.p = Vec3(4.9, 0, 0)}, .V_WB = {.w = Vec3(0, 0, 3), .v = Vec3(0, -0.3, 0)}});
  par.bodies[2].coupling = {.k = 100, .g = 6};
  par.bodies[2].device.rise = 0;
  run.in.devices[2].target.X_WD.p = Vec3(-5, 0, -100.001);
  place(run.x, 2, {.X_WB = {.p = Vec3(-5, 0, -99.995)}, .V_WB = {}});
  par.contacts.spheres[par.contacts.num_spheres++] = {.body = 2, .radius = 0.005};
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -100)}}};
  par.contacts.laws[0][0] = {.k = 1000, .c = 1};
  ASSERT_EQ(validate(par), Invalid::nothing);
}

/// In the composition that the program runs, beside bodies that swing on joints and touch.
TEST(NetMomentum, IsKeptBesideOthers) {
  bool touched = false;
  const auto others = [&](auto& run) { add_others(run); };
  expect_none(misses<JointedNetScene<ImplicitEuler>>(others));
  expect_none(misses<JointedNetScene<TrBdf2>>(others));
  auto run = in_flight<JointedNetScene<ImplicitEuler>>(0, 0.1, 12);
  add_others(*run);
  for (int n = 0; n < 200; ++n) {
    run->step();
    touched = touched || run->out.contacts.num_contacts > 0;
  }
  EXPECT_TRUE(touched);
  EXPECT_NEAR(run->x.bodies[1].x.w_B.norm(), 3, 0.01);
}

/// (48) gives back a turn that springs have braked: no more than they have.
TEST(NetMomentum, WhatIsGivenBackGainsNoEnergy) {
  Real most = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    auto run = in_flight<NetScene<ImplicitEuler>>(seed, seed % 2 == 0 ? 0.1 : 0.01, 12);
    const auto energy = [&] {
      return kinetic_energy(run->par.bodies[0].body, run->x.bodies[0].x) +
             net_kinetic_energy(run->par, run->x) + net_spring_energy(run->par, run->x);
    };
    Real lowest = energy();
    for (int n = 0; n < 500; ++n) {
      run->step();
      most = std::max(most, energy() / lowest - 1);
      lowest = std::min(lowest, energy());
    }
  }
  std::printf("rises by at most %.1e of the energy there is\n", most);
  EXPECT_LT(most, 1e-3);
}

/// Returns the largest error of velocities, in the root of the sum of m e^2, by forces of this size on all
/// nodes. An error e leaves r = A e unbalanced, A >= the masses, and sum m e^2 <= sum |r|^2 / m. The body's
/// residual is the opposite of the nodes', because with its carried nodes it is balanced.
template <class S>
Real error_of(Real residual, const Running<S>& run) {
  const auto N = static_cast<Real>(run.par.net.num_nodes);
  Real levers = 0;
  for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
    levers += (run.x.net.nodes[n].p_W - run.x.bodies[0].x.X_WB.p).norm() * 1.1;
  const RigidBodyParams& body = run.par.bodies[0].body;
  return run.par.h * residual *
         std::sqrt(N / run.par.net.nodes[0].m + N * N / body.m +
                   levers * levers / principal_moments(body.I_B).x());
}

/// Implicit Euler only: TR-BDF2 reports the residual of its last stage, and that of its first stage remains
/// in the initial velocities of this one.
TEST(NetMomentum, TheResidualBoundsTheError) {
  constexpr Real most_loose = 30;  // a residual far above the error is of no use; 16 now
  Real loosest = 0, most = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    for (const int cap : {1, 2, 3, 5, 8, 12}) {
      auto run = in_flight<NetScene<ImplicitEuler>>(seed, seed % 2 == 0 ? 0.1 : 0.01, cap);
      run->par.net.tolerance = 0;
      for (int n = 0; n < 10; ++n) {
        auto exact = std::make_unique<Running<NetScene<ImplicitEuler>>>(*run);
        solve_completely(*exact);
        exact->step();
        run->step();
        Real error_sq = 0;
        for (std::size_t i = 0; i < run->par.net.num_nodes; ++i)
          error_sq +=
              run->par.net.nodes[i].m * (run->x.net.nodes[i].v_W - exact->x.net.nodes[i].v_W).squaredNorm();
        const Real residual = run->out.net.residual;
        const Real bound = error_of(residual, *run);
        // of the linear system: springs that are majorised are taken elsewhere
        if (run->out.net.majorised || exact->out.net.majorised) continue;
        EXPECT_LE(std::sqrt(error_sq), bound * (1 + 1e-9) + 1e-12)
            << "seed " << seed << ", " << cap << " iterations";
        if (bound > 1e-9) loosest = std::max(loosest, bound / (std::sqrt(error_sq) + 1e-300));
        most = std::max(most, residual);
        EXPECT_LT(exact->out.net.residual, 1e-6 * (1 + residual));
      }
    }
  }
  std::printf("residual up to %.1e N; what it bounds is at most %.1e times as large as the error\n", most,
              loosest);
  EXPECT_GT(most, 1e-3);
  EXPECT_LE(loosest, most_loose);
}

}  // namespace
}  // namespace godobject::test_net_momentum
