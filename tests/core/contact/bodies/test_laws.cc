// Bodies in contact obey the laws of mechanics: momentum, action and reaction, rest, friction, grip.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_touching_laws {
namespace {

using Hands = FewBodies<ImplicitEuler>;
using Held = TouchingBodies<ImplicitEuler, 3, HoldingDevice>;

struct Momentum {
  Vec3 p = Vec3::Zero(), L = Vec3::Zero();  // N s; N m s about the origin
};
template <Scene S>
Momentum momentum(const Pile<S>& pile) {
  Momentum sum;
  for (std::size_t i = 0; i < pile.par.num_bodies; ++i) {
    const RigidBodyParams& body = pile.par.bodies[i].body;
    const RigidBodyState& x = pile.at(i);
    sum.p += body.m * x.v_W;
    sum.L += body.m * x.X_WB.p.cross(x.v_W) + to_world(x.X_WB.q, body.I_B * x.w_B);
  }
  return sum;
}

/// Five bricks thrown at each other.
std::unique_ptr<Pile<Hands>> crash(Real mu) {
  auto pile = std::make_unique<Pile<Hands>>();
  set_law(pile->par, law_of(2e4, 0.3, mu));
  Random random(7);
  for (int i = 0; i < 5; ++i) {
    const Vec3 from = 0.05 * random.direction();
    pile->add_brick({.X_WB = {.p = from, .q = random.rotation()},
                     .V_WB = {.w = 5 * random.vector(), .v = -8 * from + 0.05 * random.vector()}},
                    brick_mass * random.uniform(0.5, 4));
  }
  return pile;
}

TEST(TouchingLaws, CollisionsKeepMomentum) {
  for (const Real mu : {0.0, 0.4}) {
    const auto pile = crash(mu);
    const Momentum first = momentum(*pile);
    Real scale = 0;
    for (std::size_t i = 0; i < 5; ++i) scale += pile->par.bodies[i].body.m * pile->at(i).v_W.norm();
    Real worst = 0, allowed = 0, most_left = 0;
    std::size_t contacts = 0;
    for (int n = 0; n < 300; ++n) {
      pile->step();
      ASSERT_FALSE(any(pile->out.fault));
      contacts += pile->out.contacts.num_contacts;
      // unbalanced impulse of the solve on each body
      allowed += 5 * pile->out.contacts.residual * pile->par.h;
      most_left = std::max(most_left, pile->out.contacts.residual);
      const Real off = (momentum(*pile).p - first.p).norm();
      ASSERT_LE(off, allowed + 1e-10 * scale) << "step " << n;
      worst = std::max(worst, off);
    }
    EXPECT_GT(contacts, 30u);
    std::printf("mu %g: momentum off by %.1e of %.1e N s; residual up to %.1e N\n", mu, worst, scale,
                most_left);
    EXPECT_LT(worst, 1e-2 * scale);
  }
}

/// Two balls: the solve has no more than one pair, and is exact.
TEST(TouchingLaws, TwoBallsKeepMomentumExactly) {
  for (const Real mu : {0.0, 0.4})
    for (const Real ratio : {1.0, 1e3}) {
      const auto pile = std::make_unique<Pile<Hands>>();
      constexpr Real radius = 0.01;
      set_law(pile->par, law_of(2e4, 0.3, mu));
      pile->add_ball(
          {.X_WB = at(Vec3(-0.012, 0.002, 0)), .V_WB = {.w = Vec3(3, 20, -10), .v = Vec3(0.4, 0, 0.1)}},
          brick_mass, radius);
      pile->add_ball(
          {.X_WB = at(Vec3(0.012, 0, 0.003)), .V_WB = {.w = Vec3(0, 5, 9), .v = Vec3(-0.3, 0.1, 0)}},
          ratio * brick_mass, radius);
      const Momentum first = momentum(*pile);
      Real off = 0, turned = 0, allowed = 0, opposite = 0;
      std::size_t touched = 0;
      for (int n = 0; n < 100; ++n) {
        const Real v_rel = (pile->at(0).v_W - pile->at(1).v_W).norm();
        pile->step();
        const std::size_t now = pile->out.contacts.num_contacts;
        touched += now;
        const Momentum m = momentum(*pile);
        off = std::max(off, (m.p - first.p).norm() / first.p.norm());
        // the force acts where the bodies are predicted to be, h v on from where they are
        allowed += pile->par.h * pile->par.h * v_rel * pile->out.bodies[0].contact.F_W.f.norm();
        turned = std::max(turned, (m.L - first.L).norm());
        EXPECT_LE((m.L - first.L).norm(), allowed + 1e-10 * first.L.norm());
        if (now == 0) continue;
        const Vec3 sum = pile->out.bodies[0].contact.F_W.f + pile->out.bodies[1].contact.F_W.f;
        opposite = std::max(opposite, sum.norm() / pile->out.bodies[0].contact.F_W.f.norm());
      }
      EXPECT_GT(touched, 1u);
      std::printf("mu %g, masses 1 to %g: momentum off by %.1e, angular by %.1e of it\n", mu, ratio, off,
                  turned / first.L.norm());
      EXPECT_LT(off, 1e-10) << "mu " << mu << ", masses 1 to " << ratio;
      EXPECT_LT(opposite, 1e-12);
    }
}

/// A ball at rest on a shape of another body, or on another ball: its depth corresponds to its weight.
TEST(TouchingLaws, ABallRestsOnEveryKindOfBody) {
  constexpr Real radius = 0.01, m = 0.01;
  const std::array carried{ShapeParams{.kind = ShapeKind::box, .half_extents = Vec3(0.02, 0.02, 0.01)},
                           ShapeParams{.kind = ShapeKind::sphere, .radius = 0.01},
                           ShapeParams{.kind = ShapeKind::capsule,
                                       .X_WS = at(Vec3::Zero(), Vec3(pi / 2, 0, 0)),
                                       .radius = 0.01,
                                       .half_length = 0.02},
                           ShapeParams{}};  // a plane stands for none
  for (const ShapeParams& shape : carried) {
    const auto pile = std::make_unique<Pile<Hands>>();
    pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
    set_law(pile->par, law_of(2e4, 0.5, 0.3, m));
    const RigidBodyParams below = solid_ball(1, 0.02);
    pile->add(below, {});
    if (shape.kind == ShapeKind::plane) add_sphere(pile->par, 0, Vec3::Zero(), radius);
    else pile->carry(0, shape);
    pile->hold_at(0, {}, spring(below, 1e7, 1e5));
    const Real height = 0.01 + radius - m * earth_gravity / 2e4;
    pile->add_ball({.X_WB = at(Vec3(0, 0, height)), .V_WB = {}}, m, radius);
    ASSERT_TRUE(pile->run(0.3));
    const Real depth = 0.01 + radius - (pile->p(1) - pile->p(0)).z(), expected = m * earth_gravity / 2e4;
    EXPECT_NEAR(depth, expected, 0.01 * expected) << static_cast<int>(shape.kind);
    EXPECT_NEAR(pile->out.bodies[1].contact.F_W.f.z(), m * earth_gravity, 1e-6);
    EXPECT_NEAR(pile->out.bodies[0].contact.F_W.f.z(), -m * earth_gravity, 1e-6);
    EXPECT_EQ(pile->out.contacts.num_contacts, 1u);
  }
}

/// The lower of two bricks is moved along by its device from rest, at the acceleration a.
struct Carried {
  Real acceleration = 0, slip = 0;  // of the upper one: m/s^2, m
};
Carried carried_along(Real a) {
  const auto pile = std::make_unique<Pile<Hands>>();
  pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
  const Vec3 wide(0.06, 0.02, 0.005);
  const std::size_t lower = pile->add_brick({.X_WB = at(Vec3(0, 0, -0.005)), .V_WB = {}}, 0.1, wide);
  pile->hold_at(lower, at(Vec3(0, 0, -0.005)), spring(pile->par.bodies[lower].body, 1e7, 1e4));
  const std::size_t upper = pile->add_brick({.X_WB = at(Vec3(-0.02, 0, 0.005)), .V_WB = {}});
  EXPECT_TRUE(pile->run(0.2));
  const Real from = pile->p(upper).x() - pile->p(lower).x();
  Real v_1 = 0, t = 0;
  for (int n = 1; n <= 120; ++n) {
    t += pile->par.h;
    pile->lead_to(lower, Vec3(0.5 * a * t * t, 0, -0.005));
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    if (n == 60) v_1 = pile->at(upper).v_W.x();
  }
  return {.acceleration = (pile->at(upper).v_W.x() - v_1) / 0.06,
          .slip = std::abs(pile->p(upper).x() - pile->p(lower).x() - from)};
}

TEST(TouchingLaws, FrictionCarriesABrickAlong) {
  const Real cone = brick_law.mu * earth_gravity;
  for (const Real a : {0.5 * cone, 0.9 * cone}) {
    const Carried brick = carried_along(a);
    EXPECT_NEAR(brick.acceleration, a, 0.01 * a);
    EXPECT_LT(brick.slip, 5e-5) << a;
  }
  for (const Real a : {1.3 * cone, 2 * cone}) {
    const Carried brick = carried_along(a);
    EXPECT_NEAR(brick.acceleration, cone, 0.01 * cone) << a;
    const Real slip = 0.5 * (a - cone) * 0.12 * 0.12;
    EXPECT_NEAR(brick.slip, slip, 0.05 * slip) << a;
  }
}

/// The acceleration of a brick is its missing friction: g sin a (1 - share), with mu that share of tan a.
TEST(TouchingLaws, ABrickSlidesDownASlopeByItsLaw) {
  using Sliding = Pile<FewBodies<ImplicitEuler>>;
  constexpr Real slope = 0.35;
  for (const Real share : {0.9, 0.99, 0.999, 1.001}) {
    const auto pile = std::make_unique<Sliding>();
    pile->add_floor();
    pile->par.gravity_W = earth_gravity * Vec3(std::sin(slope), 0, -std::cos(slope));
    set_law(pile->par, law_of(2e4, 0.7, share * std::tan(slope)));
    pile->add_brick({.X_WB = at(Vec3(0, 0, brick_half.z())), .V_WB = {}});
    ASSERT_TRUE(pile->run(1));
    const Real before = pile->at(0).v_W.x();
    ASSERT_TRUE(pile->run(1));
    const Real weight = earth_gravity * std::sin(slope);
    EXPECT_NEAR(pile->at(0).v_W.x() - before, std::max(weight * (1 - share), 0.0), 5e-5 * weight) << share;
  }
}

TEST(TouchingLaws, ADrivenBrickPushesARow) {
  const auto pile = std::make_unique<Pile<Hands>>();
  pile->add_floor();
  const Real width = 2 * brick_half.x() + 2e-4;
  for (int i = 0; i < 6; ++i) pile->add_brick({.X_WB = at(Vec3(i * width, 0, 0.005)), .V_WB = {}});
  pile->hold_at(0, at(Vec3(0, 0, 0.005)), spring(pile->par.bodies[0].body, 2e3, 1));
  for (int n = 1; n <= 1000; ++n) {
    pile->lead_to(0, Vec3(5e-5 * n, 0, 0.005));
    pile->step();
    ASSERT_FALSE(any(pile->out.fault));
  }
  // five bricks slide on the floor
  const Real friction = 5 * brick_law.mu * brick_mass * earth_gravity;
  EXPECT_NEAR(-pile->out.bodies[0].contact.F_W.f.x(), friction * 6 / 5, 0.02 * friction);
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_NEAR(pile->at(i).v_W.x(), 0.05, 1e-3) << i;
    EXPECT_NEAR(pile->p(i).x() - pile->p(i - 1).x(), 2 * brick_half.x(), 2e-5) << i;
    EXPECT_LT(std::abs(pile->p(i).y()), 1e-4) << i;
    EXPECT_NEAR(pile->p(i).z(), 0.005, 2e-5) << i;
  }
}

/// Two driven bricks close on a third, lift it and hold it.
TEST(TouchingLaws, AGripLiftsABrick) {
  const auto pile = std::make_unique<Pile<Hands>>();
  pile->add_floor();
  const Real apart = 2 * brick_half.y();
  const std::size_t gripped = pile->add_brick({.X_WB = at(Vec3(0, 0, 0.005)), .V_WB = {}});
  std::array<std::size_t, 2> jaws{};
  for (const int j : {0, 1}) {
    const Pose X = at(Vec3(0, (j == 0 ? -1 : 1) * (apart + 5e-4), 0.007));
    jaws[static_cast<std::size_t>(j)] = pile->add_brick({.X_WB = X, .V_WB = {}});
    pile->hold_at(jaws[static_cast<std::size_t>(j)], X, spring(pile->par.bodies[1].body, 1e3, 1));
  }
  // 0.2 N each against a weight of 0.025 N, then up by 5 cm
  Vec3 lifted = Vec3::Zero();
  for (int n = 1; n <= 1600; ++n) {
    const Real approach = std::min(n / 200.0, 1.0), up = 0.05 * std::clamp((n - 300) / 300.0, 0.0, 1.0);
    for (const int j : {0, 1})
      pile->lead_to(jaws[static_cast<std::size_t>(j)],
                    Vec3(0, (j == 0 ? -1 : 1) * (apart + 5e-4 - 7e-4 * approach), 0.007 + up));
    pile->step();
    ASSERT_FALSE(any(pile->out.fault));
    if (n == 800) lifted = pile->p(gripped);
  }
  EXPECT_NEAR(lifted.z(), 0.055, 2e-4);
  EXPECT_LT((pile->p(gripped) - lifted).norm(), 1e-6);  // in 0.8 s
  EXPECT_NEAR(pile->out.bodies[gripped].contact.F_W.f.z(), brick_mass * earth_gravity, 1e-6);
}

/// A brick gripped in the air is lowered on another, pressed, and released: it stays there.
TEST(TouchingLaws, AHeldBrickIsPlacedOnAnother) {
  const auto pile = std::make_unique<Pile<Held>>();
  pile->add_floor();
  pile->add_brick({.X_WB = at(Vec3(0, 0, 0.005)), .V_WB = {}});
  const std::size_t held =
      pile->add_brick({.X_WB = at(Vec3(0.002, 0.001, 0.03), Vec3(0, 0, 0.1)), .V_WB = {}});
  pile->par.bodies[held].coupling = spring(pile->par.bodies[held].body, 200, 0.05);
  auto& device = pile->in.devices[held];
  device.target.X_WD = at(Vec3(0.1, 0.2, 0.3), Vec3(1, 0, 0));
  device.engaged = true;
  for (int n = 1; n <= 1000; ++n) {
    pile->lead_to(held, Vec3(0.1, 0.2, 0.3 - 0.018 * std::min(n / 800.0, 1.0)));
    pile->step();
    ASSERT_FALSE(any(pile->out.fault));
  }
  // 3 mm below its place on the other one
  EXPECT_NEAR(pile->out.bodies[held].contact.F_W.f.z(), 200 * 0.003 + brick_mass * earth_gravity, 0.02);
  EXPECT_NEAR(pile->p(held).z(), 0.015, 3e-5);
  device.engaged = false;
  Real fastest = 0;
  for (int n = 0; n < 500; ++n) {
    pile->step();
    fastest = std::max(fastest, pile->at(held).v_W.norm());
  }
  EXPECT_LT(fastest, 0.05);
  EXPECT_NEAR(pile->p(held).z(), 0.015, 1e-5);
  EXPECT_LT(pile->kinetic(), 1e-12);
}

}  // namespace
}  // namespace godobject::test_touching_laws
