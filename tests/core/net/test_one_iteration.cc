// Light nets on tools thrown on the floor, their iterations cut off after one to three. With stiff springs
// p^T A p is below its rounding at times, and must not produce velocities. No net gains energy.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_one_iteration {
namespace {

/// Ranges of the drawn masses, kg, and stiffnesses, N/m, and the limit of iterations.
struct Light {
  Real max_m = 1e-6, min_k = 1e7;
  int max_iterations = 1;
};

/// A tool of two spheres with a sheet that touches nothing.
template <class I>
std::unique_ptr<Running<NetScene<I>>> thrown(unsigned seed, const Light& net = {}) {
  Random random(seed);
  auto run = std::make_unique<Running<NetScene<I>>>();
  auto& par = run->par;
  par.h = random.log_uniform(1e-3, 4e-3);
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = rigid_body(0.07, random.inertia(Vec3(1.8e-5, 1.8e-5, 3e-5)));
  const Real m = random.log_uniform(1e-7, net.max_m), k = random.log_uniform(net.min_k, 1e9);
  Stuff stuff{.m = m, .k = k, .g = 0.02 * std::sqrt(k * m), .k_a = random.log_uniform(0.1, 1), .carrier = 0};
  stuff.g_a = 1.4 * std::sqrt(stuff.k_a * m);
  add_sheet(par, stuff, 5, 4, 0.01);
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) par.net.nodes[n].p_B += 2e-3 * random.vector();
  for (std::size_t s = 0; s < par.net.num_springs; ++s) {
    NetSpring& spring = par.net.springs[s];
    spring.l_0 = (par.net.nodes[spring.j].p_B - par.net.nodes[spring.i].p_B).norm();
  }
  par.net.max_iterations = net.max_iterations;
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {}};
  const Real k_c = random.log_uniform(1e3, 1e5), c = random.uniform(1, 20) * std::sqrt(k_c * 0.07);
  par.contacts.laws[0][0] = {.k = k_c, .c = c, .mu = random.uniform(0, 2), .k_t = k_c, .c_t = c};
  for (const Real x : {0.0, 0.012})
    par.contacts.spheres[par.contacts.num_spheres++] = {.body = 0, .p_B = Vec3(x, 0, 0), .radius = 0.006};
  run->in.devices[0].engaged = run->in.devices[0].valid = false;
  place(run->x, 0,
        {.X_WB = {.p = Vec3(0, 0, 0.03), .q = random.rotation()},
         .V_WB = {.w = random.vector(), .v = random.vector()}});
  place_net(par.net, run->x);
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

/// Checks the committed state: falls and throws reach some metres a second. No step is rejected (58).
template <class I>
void expect_no_speed_of_rounding() {
  Real fastest = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    auto run = thrown<I>(seed);
    bool is_refused = false;
    for (int n = 0; n < 400; ++n) {
      run->step();
      is_refused = is_refused || any(run->out.fault);
      for (std::size_t i = 0; i < run->par.net.num_nodes; ++i)
        fastest = std::max(fastest, run->x.net.nodes[i].v_W.norm());
    }
    refused += is_refused;
  }
  std::printf("%s: %.1e m/s, steps refused in %d runs\n", I::name, fastest, refused);
  EXPECT_LT(fastest, 100);
  EXPECT_EQ(refused, 0);
}
TEST(NetOneIteration, CommitsNoSpeedOfRounding) {
  expect_no_speed_of_rounding<ImplicitEuler>();
  expect_no_speed_of_rounding<TrBdf2>();
}

/// Checks that no step ends with more energy than it starts with. If the springs are majorised, the stage is
/// solved a second time, after forces of contacts that pulled in the first.
template <class I>
void expect_no_gain() {
  constexpr unsigned cases = 100;
  constexpr Real tolerance = 0.02;  // of the energy
  Real worst = 0;
  int refused = 0;
  for (int limit = 1; limit <= 3; ++limit) {
    for (unsigned seed = 0; seed < cases; ++seed) {
      auto run = thrown<I>(seed, {.max_m = 1e-5, .min_k = 10, .max_iterations = limit});
      EnergyBalance<NetScene<I>> balance;
      balance.start(run->par, run->x);
      Real gain = 0;
      for (int n = 0; n < 300; ++n) {
        const Real E = balance.energy(), before = balance.balance();
        run->step();
        if (any(run->out.fault)) {
          ++refused;
          break;
        }
        balance.observe(run->par, run->x, run->w, run->out);
        gain = std::max(gain, (balance.balance() - before) / E);
      }
      EXPECT_LT(gain, tolerance) << I::name << ", seed " << seed << ", " << limit << " iterations";
      worst = std::max(worst, gain);
    }
  }
  std::printf("%s: largest gain in a step %.1e of the energy\n", I::name, worst);
  EXPECT_EQ(refused, 0);
}
TEST(NetOneIteration, GainsNoEnergyWithImplicitEuler) { expect_no_gain<ImplicitEuler>(); }
TEST(NetOneIteration, GainsNoEnergyWithTrBdf2) { expect_no_gain<TrBdf2>(); }

}  // namespace
}  // namespace godobject::test_net_one_iteration
