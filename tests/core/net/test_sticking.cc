// Nodes that stick stay where they stick on a body, however it moves (51).
#include <gtest/gtest.h>

#include "tests/core/net/net_scene.h"

namespace godobject::test_sticking_nodes {
namespace {

constexpr Real radius = 2e-3, depth = 1e-4;  // m

/// A heavy frame that turns by itself, and a strip of four nodes that is pressed between its jaws.
template <class I>
struct Pinched : Running<NetScene<I, 1>> {
  Pinched(Random& random, Real h) {
    auto& par = this->par;
    par.h = h;
    par.num_bodies = 1;
    par.bodies[0].body = rigid_body(1e6, 1e6 * Mat3::Identity());
    this->in.devices[0].engaged = false;
    par.contacts.laws[0][0] = {.k = 2e3, .c = 4, .mu = 0.5, .k_t = 2e3, .c_t = 4};
    add_sheet(par, {.m = 1e-3, .k = 50, .g = 0.1, .radius = radius}, 2, 2, 0.01);
    const Vec3 w_W = random.uniform(1, 6) * random.direction();
    const Pose X_WF = {.p = random.vector(), .q = random.rotation()};
    const Pose X_FS = {.p = random.uniform(0.02, 0.2) * random.direction(), .q = random.rotation()};
    const Vec3 half(0.04, 0.03, 0.01);
    for (const Real side : {-1, 1}) {
      const Vec3 p_S(0, 0, side * (radius + half.z() - depth));
      par.contacts.surfaces[par.contacts.num_surfaces++] = {
          .body = 0,
          .shape = {.kind = ShapeKind::box,
                    .X_WS = {.p = X_FS.p + X_FS.q * p_S, .q = X_FS.q},
                    .half_extents = half}};
    }
    place(this->x, 0, {.X_WB = X_WF, .V_WB = {.w = w_W}});
    place_net(par.net, this->x);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
      auto& node = this->x.net.nodes[n];
      node.p_W = X_WF.p + X_WF.q * (X_FS.p + X_FS.q * par.net.nodes[n].p_B);
      node.v_W = w_W.cross(node.p_W - X_WF.p);
    }
    EXPECT_EQ(validate(par), Invalid::nothing);
  }
  /// Returns the place of a node in the frame.
  Vec3 seen(std::size_t n) const {
    const Pose& X_WF = this->x.bodies[0].x.X_WB;
    return X_WF.q.conjugate() * (this->x.net.nodes[n].p_W - X_WF.p);
  }
  void run(Real t) {
    for (long n = std::lround(t / this->par.h); n > 0; --n) {
      this->step();
      ASSERT_EQ(this->out.fault, Fault::none);
    }
  }
};

template <class I>
class StickingNodes : public testing::Test {};
using Integrators = testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(StickingNodes, Integrators);

/// Iterations end at changes of velocity of 1e-12 m/s, which the next steps pull back.
TYPED_TEST(StickingNodes, DoNotCreepInATurningSlot) {
  Random random(1);
  Real farthest = 0;
  for (const Real h : {1e-3, 4e-3}) {
    for (int n = 0; n < 4; ++n) {
      Pinched<TypeParam> scene(random, h);
      scene.par.net.max_iterations = 2000;
      scene.par.net.tolerance = 1e-12 / (h * h);
      scene.run(1);
      EXPECT_EQ(scene.out.net.num_contacts, 8u);
      std::array<Vec3, 4> before;
      for (std::size_t i = 0; i < 4; ++i) before[i] = scene.seen(i);
      scene.run(1);
      for (std::size_t i = 0; i < 4; ++i) {
        const Real creep = (scene.seen(i) - before[i]).norm();
        EXPECT_LE(creep, 1e-12) << "h " << h;
        farthest = std::max(farthest, creep);
      }
    }
  }
  std::printf("%s: %.1e m\n", TypeParam::name, farthest);
}

}  // namespace
}  // namespace godobject::test_sticking_nodes
