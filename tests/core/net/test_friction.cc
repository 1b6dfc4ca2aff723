// Friction of nodes that slide slowly, begin to slide and stick: it converges in few iterations (50), to the
// law (23).
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_friction {
namespace {

constexpr Real mu = 0.4;

/// A sheet on a carrier, lowered on a plane, then moved to and fro along it, slower and slower.
template <class I>
struct Dragged : Running<NetScene<I>> {
  Dragged() {
    auto& par = this->par;
    par.h = 1e-3;
    par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
    par.bodies[0].coupling = {.k = 2000, .g = 20, .k_r = 1, .g_r = 0.02};
    par.bodies[0].device.rise = 0;
    add_sheet(par, {.m = 2e-5, .k = 200, .g = 0.013, .k_a = 20, .g_a = 0.04, .radius = 1e-3, .carrier = 0}, 8,
              8, 3e-3);
    par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -1e-3)}}};
    par.contacts.laws[0][0] = {.k = 2000, .c = 0.1, .mu = mu, .k_t = 2000, .c_t = 0.1};
    place(this->x, 0, {});
    place_net(par.net, this->x);
    engage_at(this->x, 0, {});
    EXPECT_EQ(validate(par), Invalid::nothing);
  }
  void step_to(Real t) {
    const Real omega = 2 * pi * 4, far = 4e-3 * std::exp(-2 * t);
    this->in.devices[0] = {.target = {.X_WD = {.p = Vec3(far * std::sin(omega * t), 0, -2e-3)},
                                      .V_WD = {.v = Vec3(far * omega * std::cos(omega * t), 0, 0)}}};
    this->in.devices[0].engaged = this->in.devices[0].valid = true;
    this->step();
  }
};

/// Counts the steps of 1000 with four Newton iterations or more: 144 with implicit Euler and 28 with TR-BDF2
/// without (50), 13 and none with it.
template <class I>
int count_long_steps() {
  auto run = std::make_unique<Dragged<I>>();
  int long_steps = 0, newton_iterations = 0;
  for (int n = 1; n <= 1000; ++n) {
    run->step_to(n * run->par.h);
    EXPECT_EQ(run->out.fault, Fault::none);
    newton_iterations += run->out.net.newton_iterations;
    if (run->out.net.newton_iterations >= 4) ++long_steps;
    constexpr Real missed = 2e-3;  // N
    const auto& forces = run->w.contacts.net.forces;
    for (std::size_t i = 0; i < forces.size; ++i) {
      const Vec3 &n_W = forces.list[i].n_W, &F_W = forces.list[i].F_W;
      const Real F_n = n_W.dot(F_W), F_t = (F_W - F_n * n_W).norm();
      EXPECT_LE(F_t, mu * F_n + missed) << "step " << n;
    }
  }
  std::printf("%s: %d long steps, %d Newton iterations\n", I::name, long_steps, newton_iterations);
  return long_steps;
}

TEST(NetFriction, IsFoundInFewIterationsWithImplicitEuler) {
  EXPECT_LT(count_long_steps<ImplicitEuler>(), 25);
}
TEST(NetFriction, IsFoundInFewIterationsWithTrBdf2) { EXPECT_LT(count_long_steps<TrBdf2>(), 5); }

}  // namespace
}  // namespace godobject::test_net_friction
