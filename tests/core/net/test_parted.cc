// Chains with a heavy end and a net on a light link, whose joints do not hold in an undivided stage. Nodes
// are moved from substep to substep with the bodies (39).
#include <gtest/gtest.h>

#include "tests/core/net/usual_scene.h"
#include "tests/core/snapping_chain.h"

namespace godobject::test_net_parted {
namespace {

inline constexpr Real holds = 1e-5;  // m, as required by tests/core/joint/test_heavy_ends.cc

/// A chain in steps of 5 ms, with a sheet on its second link.
template <class I>
std::unique_ptr<Running<JointedNetScene<I>>> chain_with_net(std::size_t links, Real angle, bool on_world) {
  auto run = std::make_unique<Running<JointedNetScene<I>>>();
  auto& par = run->par;
  par.h = 5e-3;
  build_snapping_chain(*run, links, angle, on_world);
  add_sheet(par, Stuff{.m = 1e-3, .k = 100, .g = 0.02, .k_a = 20, .g_a = 0.01, .carrier = 1}, 4, 4, 0.01);
  place_net(par.net, run->x);
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

template <class I>
void expect_chains_to_hold() {
  for (const std::size_t links : {3, 4}) {
    const auto run = chain_with_net<I>(links, 160 * pi / 180, true);
    const Snapped snapped = snap(*run, 2000);
    EXPECT_LT(snapped.drift, holds) << I::name << ", " << links << " links";
    EXPECT_FALSE(snapped.gains) << I::name << ", " << links << " links";
  }
}

TEST(NetParted, ChainsThatSnapTautHold) {
  expect_chains_to_hold<ImplicitEuler>();
  expect_chains_to_hold<TrBdf2>();
}

/// sum m v of links and nodes.
template <class S>
Vec3 momentum(const Running<S>& run) {
  Vec3 P_W = Vec3::Zero();
  for (std::size_t i = 0; i < run.par.num_bodies; ++i)
    P_W += run.par.bodies[i].body.m * run.x.bodies[i].x.v_W;
  for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
    P_W += run.par.net.nodes[n].m * run.x.net.nodes[n].v_W;
  return P_W;
}

template <class I>
void expect_flights_to_hold() {
  for (const Real spin : {0, 30, 100}) {  // rad/s
    const auto run = chain_with_net<I>(4, 0, false);
    place(run->x, 3, {.X_WB = run->x.bodies[3].x.X_WB, .V_WB = {.w = Vec3(spin, 0, 0), .v = Vec3(0, 30, 0)}});
    const Vec3 before = momentum(*run);
    const Snapped snapped = snap(*run, 400);
    EXPECT_LT(snapped.drift, holds) << I::name << ", " << spin << " rad/s";
    EXPECT_FALSE(snapped.gains) << I::name << ", " << spin << " rad/s";
    EXPECT_LT((momentum(*run) - before).norm(), 1e-12 * before.norm()) << I::name << ", " << spin << " rad/s";
  }
}

// the heavy end draws the links along at 30 m/s
TEST(NetParted, ChainsInFlightHoldAndKeepMomentum) {
  expect_flights_to_hold<ImplicitEuler>();
  expect_flights_to_hold<TrBdf2>();
}

}  // namespace
}  // namespace godobject::test_net_parted
