// Displayed wrench of a net: a tool of nodes pressed on a plane. Also bodies hit by nets in free flight.
#include <gtest/gtest.h>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_hand {
namespace {

/// A net that the hand presses on a plane, askew, until it rests.
template <class I>
void expect_one_force_for_all() {
  constexpr Real k = 1000, k_d = 400, close = 1e-6;  // N/m: of coupling and feedback; of the force
  auto run = std::make_unique<Running<JointedNetScene<I>>>();
  auto& par = run->par;
  auto& tool = par.bodies[0];
  tool.body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  tool.coupling = {.k = k, .g = 20, .k_r = 1, .g_r = 0.02};
  tool.feedback.gains = {.k = k_d};
  tool.feedback.max_force = tool.feedback.max_torque = 100;
  tool.feedback.max_force_rate = tool.feedback.max_torque_rate = 1e6;
  tool.device.rise = 0;
  add_sheet(par, {.m = 1e-4, .k = 50, .g = 0.02, .k_a = 50, .g_a = 0.05, .radius = 2e-3, .carrier = 0}, 5, 4,
            0.01);
  par.net.max_iterations = 2000;  // to the end
  par.net.tolerance = 1e-13 / (par.h * par.h);
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
  par.contacts.laws[0][0] = {.k = 100, .c = 0.05};
  place_net(par.net, run->x);
  engage_at(run->x, 0, {});
  run->in.devices[0].target.X_WD = {.p = Vec3(0, 0, -0.02), .q = exp_so3(Vec3(0.1, 0.05, 0))};
  ASSERT_EQ(validate(par), Invalid::nothing);
  run->step(6000);
  EXPECT_EQ(run->out.fault, Fault::none);

  const Pose& X_WB = run->body().X_WB;
  const Vec3 coupling = k * (run->in.devices[0].target.X_WD.p - X_WB.p);
  Vec3 anchors = Vec3::Zero(), contacts = Vec3::Zero();  // on the tool, on the net
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    const NetNode& node = par.net.nodes[n];
    anchors += node.k * (run->x.net.nodes[n].p_W - X_WB.p - X_WB.q * node.p_B);
  }
  const auto& net = run->w.contacts.net;
  for (std::size_t c = 0; c < net.near.size; ++c) contacts += lane(net.packs[c / 4].F, c % 4);
  const Vec3 shown = run->out.bodies[0].feedback.F_D.f;
  const Real force = contacts.norm();
  std::printf("%s: %.3f N of %zu contacts; coupling, anchors and feedback miss %.1e, %.1e, %.1e of it\n",
              I::name, force, run->out.net.num_contacts, (coupling + contacts).norm() / force,
              (anchors - contacts).norm() / force, (shown * (k / k_d) - contacts).norm() / force);
  EXPECT_GT(force, 1);
  EXPECT_GE(run->out.net.num_contacts, 2u);
  EXPECT_LT((coupling + contacts).norm(), close * force);
  EXPECT_LT((anchors - contacts).norm(), close * force);
  EXPECT_LT((shown * (k / k_d) + coupling).norm(), close * force);
  EXPECT_LT((shown * (k / k_d) - contacts).norm(), close * force);
}

TEST(NetHand, FeelsWhatContactsAnchorsAndCouplingBear) {
  expect_one_force_for_all<ImplicitEuler>();
  expect_one_force_for_all<TrBdf2>();
}

/// Returns the largest error of the momentum of a body with its net that flies at another body, which has a
/// box or a sphere. As a share of the initial momentum.
template <class I>
Real worst_miss(int cap) {
  Real worst = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(seed);
    auto run = std::make_unique<Running<JointedNetScene<I>>>();
    auto& par = run->par;
    par.num_bodies = 2;
    for (std::size_t i = 0; i < 2; ++i) {
      par.bodies[i].body = rigid_body(random.log_uniform(0.01, 0.1), random.inertia(Vec3(4e-6, 5e-6, 7e-6)));
      run->in.devices[i] = {};
    }
    const Real k = random.log_uniform(30, 300), m = random.log_uniform(1e-4, 1e-3), k_a = 0.3 * k;
    add_tube(par,
             {.m = m,
              .k = k,
              .g = 0.1 * std::sqrt(k * m),
              .k_a = k_a,
              .g_a = 0.1 * std::sqrt(k_a * m),
              .radius = 4e-3,
              .carrier = 0},
             8, 6, 0.01);
    par.net.max_iterations = cap;
    place(run->x, 0, {.X_WB = {.q = random.rotation()}, .V_WB = {.w = random.vector(), .v = Vec3(1, 0, 0)}});
    place(run->x, 1,
          {.X_WB = {.p = Vec3(0.08, 0.005, 0), .q = random.rotation()}, .V_WB = {.w = random.vector()}});
    if (seed % 2 == 0)
      par.contacts.surfaces[par.contacts.num_surfaces++] = {
          .body = 1, .shape = {.kind = ShapeKind::box, .half_extents = Vec3(0.01, 0.02, 0.015)}};
    else par.contacts.spheres[par.contacts.num_spheres++] = {.body = 1, .radius = 0.015};
    par.contacts.laws[0][0] = {.k = 500, .c = 0.1, .mu = 0.3, .k_t = 500, .c_t = 0.1};
    place_net(par.net, run->x);
    EXPECT_EQ(validate(par), Invalid::nothing);
    Real scale = 0;
    const auto momentum = [&] {
      Vec3 P = Vec3::Zero();
      scale = 0;
      const auto add = [&](Real mass, const Vec3& v) {
        P += mass * v;
        scale += mass * v.norm();
      };
      for (std::size_t i = 0; i < 2; ++i) add(par.bodies[i].body.m, run->x.bodies[i].x.v_W);
      for (std::size_t n = 0; n < par.net.num_nodes; ++n) add(par.net.nodes[n].m, run->x.net.nodes[n].v_W);
      return P;
    };
    const Vec3 before = momentum();
    const Real scale_before = scale;
    std::size_t contacts = 0;
    for (int n = 0; n < 300; ++n) {
      run->step();
      EXPECT_EQ(run->out.fault, Fault::none);
      contacts += run->out.net.num_contacts;
      worst = std::max(worst, (momentum() - before).norm() / scale_before);
    }
    EXPECT_GT(contacts, 0u) << "seed " << seed;
    EXPECT_GT(run->x.bodies[1].x.v_W.norm(), 1e-3) << "seed " << seed;
  }
  std::printf("%s, at most %d iterations: momentum of net and what it hits within %.1e of what it was\n",
              I::name, cap, worst);
  return worst;
}

TEST(NetHand, WhatANetHitsTakesWhatTheNetLoses) {
  constexpr int by_default = 12, few = 1;
  EXPECT_LT(worst_miss<ImplicitEuler>(by_default), 1e-11);
  EXPECT_LT(worst_miss<TrBdf2>(by_default), 1e-11);
  // Known: cut off after one iteration, contacts between bodies and nets lose some. Printed, not asserted.
  worst_miss<ImplicitEuler>(few);
  worst_miss<TrBdf2>(few);
}

}  // namespace
}  // namespace godobject::test_net_hand
