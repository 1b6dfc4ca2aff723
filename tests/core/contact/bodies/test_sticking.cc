// Points that stick stay where they stick on both bodies, however these move (51).
#include <gtest/gtest.h>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_sticking {
namespace {

/// A heavy frame with a slot, and a brick that is pressed between its jaws. The frame turns by itself.
template <class I>
struct Carried : Pile<TouchingBodies<I, 2>> {
  static constexpr Real depth = 1e-4;  // of the spheres in the jaws, m

  Carried(Random& random, Real h) {
    this->par.h = h;
    set_law(this->par, law_of(2e3, 1.4, 0.5));
    const Vec3 w_W = random.uniform(1, 6) * random.direction(), v_W = random.vector();
    const Pose X_WF = {.p = random.vector(), .q = random.rotation()};
    const Pose X_FS = {.p = random.uniform(0.02, 0.2) * random.direction(), .q = random.rotation()};
    this->add(rigid_body(1e6, 1e6 * Mat3::Identity()), {.X_WB = X_WF, .V_WB = {.w = w_W, .v = v_W}});
    const Vec3 p_W = X_WF.p + X_WF.q * X_FS.p;
    this->add_brick(
        {.X_WB = {.p = p_W, .q = X_WF.q * X_FS.q}, .V_WB = {.w = w_W, .v = v_W + w_W.cross(p_W - X_WF.p)}});
    // surfaces in the order of their bodies
    auto& contacts = this->par.contacts;
    const Surface of_brick = contacts.surfaces[0];
    contacts.num_surfaces = 0;
    const Vec3 half(0.04, 0.03, 0.01);
    for (const Real side : {-1, 1}) {
      const Vec3 p_S(0, 0, side * (brick_half.z() + half.z() - depth));
      contacts.surfaces[contacts.num_surfaces++] = {
          .body = 0,
          .shape = {.kind = ShapeKind::box,
                    .X_WS = {.p = X_FS.p + X_FS.q * p_S, .q = X_FS.q},
                    .half_extents = half}};
    }
    contacts.surfaces[contacts.num_surfaces++] = of_brick;
  }
  /// Returns the brick's place in the frame.
  Pose seen() const {
    const Quat to_frame = this->at(0).X_WB.q.conjugate();
    return {.p = to_frame * (this->p(1) - this->p(0)), .q = to_frame * this->at(1).X_WB.q};
  }
  void run(Real t) {
    for (long n = std::lround(t / this->par.h); n > 0; --n) {
      this->step();
      ASSERT_EQ(this->out.fault, Fault::none);
    }
  }
};

template <class I>
class Sticking : public testing::Test {};
using Integrators = testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Sticking, Integrators);

/// A step moves an anchor by rounding: some 1e-16 of a distance of 3 m, as a random walk of n steps.
TYPED_TEST(Sticking, ABrickInATurningSlotDoesNotCreep) {
  Random random(1);
  Real farthest = 0, turned = 0;
  for (const Real h : {1e-4, 1e-3, 4e-3, 1e-3, 4e-3}) {
    for (int n = 0; n < (h < 1e-3 ? 2 : 8); ++n) {
      Carried<TypeParam> scene(random, h);
      scene.run(1);
      EXPECT_GT(scene.out.contacts.num_contacts, 8u);
      const Pose before = scene.seen();
      scene.run(1);
      const Pose after = scene.seen();
      const Real creep = (after.p - before.p).norm(), turn = before.q.angularDistance(after.q);
      const Real rounding = 2e-14 * std::sqrt(1 / h);
      EXPECT_LE(creep, rounding) << "h " << h;
      EXPECT_LE(turn, rounding / brick_half.z()) << "h " << h;
      farthest = std::max(farthest, creep);
      turned = std::max(turned, turn);
    }
  }
  std::printf("%s: %.1e m, %.1e rad\n", TypeParam::name, farthest, turned);
}

/// A ball that rolls on a plane keeps its speed, and its drag on the plane stays nothing.
TYPED_TEST(Sticking, ARollingBallIsNotResisted) {
  Random random(2);
  for (const Real h : {1e-4, 1e-3, 4e-3}) {
    Pile<TouchingBodies<TypeParam, 1>> scene;
    scene.par.h = h;
    scene.add_floor();
    const Real radius = 0.02, v = random.uniform(0.1, 0.6), way = random.uniform(-pi, pi);
    const Vec3 v_W = v * Vec3(std::cos(way), std::sin(way), 0), w_W = Vec3::UnitZ().cross(v_W) / radius;
    scene.add_ball(
        {.X_WB = {.p = Vec3(0, 0, radius - 1e-6), .q = random.rotation()}, .V_WB = {.w = w_W, .v = v_W}}, 0.1,
        radius);
    for (long n = std::lround(1 / h); n > 0; --n) scene.step();
    EXPECT_NEAR((scene.at(0).v_W - v_W).template head<2>().norm(), 0, 1e-11) << "h " << h;
    ASSERT_EQ(scene.x.contacts.size, 1u);
    EXPECT_LE(scene.x.contacts.list[0].xi_a.vec().norm(), 1e-13) << "h " << h;
  }
}

}  // namespace
}  // namespace godobject::test_sticking
