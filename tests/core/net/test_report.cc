// The report of a step on its nets is of its worst stage. TR-BDF2 begins with an implicit Euler stage of c h,
// and reports at least as much as an implicit Euler step of that length.
#include <gtest/gtest.h>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_report {
namespace {

/// A sheet in the world that is thrown at a plane on which some of its nodes lie, in a step of h.
template <class I>
NetReport report_of_first_step(unsigned seed, Real h) {
  Random random(seed);
  auto run = std::make_unique<Running<NetScene<I>>>();
  auto& par = run->par;
  par.h = h;
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  add_sheet(par, {.m = 1e-4, .k = 50, .g = 0.02, .k_a = 5, .g_a = 0.01, .radius = 2e-3}, 6, 6, 0.01);
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
  par.contacts.laws[0][0] = {.k = 200, .c = 0.05, .mu = 0.4, .k_t = 200, .c_t = 0.05};
  place_net(par.net, run->x);
  place(run->x, 0, {.X_WB = {.p = Vec3(0, 0, 1)}, .V_WB = {}});
  for (std::size_t n = 0; n < par.net.num_nodes; ++n)
    run->x.net.nodes[n].v_W = 0.2 * random.vector() - Vec3(0, 0, 0.1);
  run->in.devices[0] = {};
  EXPECT_EQ(validate(par), Invalid::nothing);
  run->step();
  EXPECT_EQ(run->out.fault, Fault::none);
  return run->out.net;
}

TEST(NetReport, IsThatOfTheWorstStage) {
  constexpr Real h = 1e-3, rounding = 1e-6;  // s; of two programs
  for (unsigned seed = 0; seed < 50; ++seed) {
    const NetReport whole = report_of_first_step<TrBdf2>(seed, h),
                    first = report_of_first_step<ImplicitEuler>(seed, TrBdf2::c * h);
    EXPECT_GE(whole.iterations, first.iterations) << "seed " << seed;
    EXPECT_GE(whole.newton_iterations, first.newton_iterations) << "seed " << seed;
    EXPECT_GE(whole.residual, (1 - rounding) * first.residual) << "seed " << seed;
  }
}

/// Steps of a sheet at a plane whose iterations were stopped at `most`.
template <class I>
int stopped_steps(int most) {
  auto run = std::make_unique<Running<NetScene<I>>>();
  auto& par = run->par;
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  add_sheet(par, {.m = 1e-4, .k = 50, .g = 0.02, .k_a = 5, .g_a = 0.01, .radius = 2e-3}, 6, 6, 0.01);
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
  par.contacts.laws[0][0] = {.k = 200, .c = 0.05, .mu = 0.4, .k_t = 200, .c_t = 0.05};
  par.net.max_iterations = most;
  place_net(par.net, run->x);
  place(run->x, 0, {.X_WB = {.p = Vec3(0, 0, 1)}, .V_WB = {}});
  for (std::size_t n = 0; n < par.net.num_nodes; ++n)
    run->x.net.nodes[n].v_W = Vec3(0, 0, n % 2 ? 0.1 : -0.3);
  run->in.devices[0] = {};
  int stopped = 0;
  for (int n = 0; n < 20; ++n) {
    run->step();
    EXPECT_EQ(has(run->out.limited, Limited::net_cap), run->out.net.is_stopped);
    stopped += run->out.net.is_stopped ? 1 : 0;
  }
  return stopped;
}

TEST(NetReport, SaysThatAnIterationWasStopped) {
  EXPECT_GT(stopped_steps<ImplicitEuler>(1), 0);
  EXPECT_GT(stopped_steps<TrBdf2>(1), 0);
  EXPECT_EQ(stopped_steps<ImplicitEuler>(200), 0);
  EXPECT_EQ(stopped_steps<TrBdf2>(200), 0);
}

}  // namespace
}  // namespace godobject::test_net_report
