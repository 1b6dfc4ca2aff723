// Boxes that touch by their edges alone: bars across each other, bricks on rails and ridges of the world, and
// bricks thrown at each other. Eight small spheres at their corners would not touch.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <iostream>

#include "tests/core/contact/usual_scenes.h"
#include "tests/support/box_overlap.h"

namespace godobject::test_touching_ridges {
namespace {

using namespace box_overlap;

#ifdef NDEBUG
constexpr int throws = 400;
constexpr Real resting = 5;  // s
#else
constexpr int throws = 2;  // builds with assertions and sanitizers take a hundred times as long
constexpr Real resting = 0.1;
#endif

constexpr Real small_radius = 5e-4;
inline const Vec3 bar_half(0.03, 0.004, 0.004);

class Bars : public Pile<FewBodies<ImplicitEuler>> {
 public:
  /// A solid box with spheres of this radius at its corners alone.
  std::size_t add_bar(const Start& start, const Vec3& half, Real radius = small_radius) {
    const std::size_t i = add(solid_box(brick_mass, half), start);
    const Vec3 corner = half - Vec3::Constant(radius);
    for (int k = 0; k < 8; ++k)
      add_sphere(par, i, corner.cwiseProduct(Vec3(k % 2 == 0 ? -1 : 1, k % 4 < 2 ? -1 : 1, k < 4 ? -1 : 1)),
                 radius);
    carry(i, {.kind = ShapeKind::box, .half_extents = half});
    return i;
  }
  PosedBox box(std::size_t i) const {
    const Pose& X = at(i).X_WB;
    return {.p = X.p,
            .h = par.contacts.surfaces[par.contacts.num_surfaces - par.num_bodies + i].shape.half_extents,
            .R = X.q.toRotationMatrix()};
  }
};

struct RestCase {
  Real yaw, k, zeta;
};
std::ostream& operator<<(std::ostream& os, const RestCase& c) {
  return os << "yaw " << c.yaw << ", k " << c.k << " N/m, " << c.zeta << " times critical";
}
std::vector<RestCase> rest_cases() {
  std::vector<RestCase> all;
  for (const Real yaw : {pi / 2, 1.1, 2.0})
    for (const Real k : {1e3, 2e4, 1e6, 1e8})
      for (const Real zeta : {0.1, 1.0}) all.push_back({.yaw = yaw, .k = k, .zeta = zeta});
  return all;
}

/// Checks that body i, carried by four crossings, comes to rest at the depth of its weight and stays. top: of
/// its support.
void expect_to_rest(const RestCase& c, std::size_t i, const std::function<Real()>& top, Bars& pile) {
  SCOPED_TRACE(::testing::Message() << c);
  const Real weight = brick_mass * earth_gravity, half = pile.box(i).h.z();
  ASSERT_TRUE(pile.run(resting / 2));
  const std::vector<Vec3> settled = pile.positions();
  ASSERT_TRUE(pile.run(resting / 2));
  EXPECT_NEAR(pile.out.bodies[i].contact.F_W.f.z(), weight, 1e-5 * weight);
  EXPECT_LT(pile.out.bodies[i].contact.F_W.f.head<2>().norm(), 1e-5 * weight);
  EXPECT_LT(pile.kinetic(), 1e-12);
  EXPECT_LT(pile.drift_since(settled), 1e-8);
  const Real depth = top() + half - pile.p(i).z(), expected = weight / (4 * c.k);
  EXPECT_NEAR(depth, expected, 1e-3 * expected + 1e-10);
}

TEST(TouchingRidges, ABarRestsAcrossAnother) {
  for (const RestCase& c : rest_cases()) {
    const auto pile = std::make_unique<Bars>();
    pile->add_floor();
    set_law(pile->par, law_of(c.k, c.zeta));
    pile->add_bar({.X_WB = at(Vec3(0, 0, bar_half.z())), .V_WB = {}}, bar_half);
    pile->add_bar({.X_WB = at(Vec3(0, 0, 3 * bar_half.z()), Vec3(0, 0, c.yaw)), .V_WB = {}}, bar_half);
    expect_to_rest(
        c, 1, [&] { return pile->p(0).z() + bar_half.z(); }, *pile);
    // four spheres on the floor, four edges across
    EXPECT_EQ(pile->out.contacts.num_contacts, 8u);
    EXPECT_NEAR(pile->out.bodies[0].contact.F_W.f.z(), brick_mass * earth_gravity, 1e-6);
  }
}

/// Dropped, tilted, off the middle.
TEST(TouchingRidges, ABarFallsOnAnotherAndStays) {
  Random random(1);
  for (int n = 0; n < 12; ++n) {
    SCOPED_TRACE(n);
    const auto pile = std::make_unique<Bars>();
    pile->add_floor();
    pile->add_bar({.X_WB = at(Vec3(0, 0, bar_half.z())), .V_WB = {}}, bar_half);
    const Vec3 from(random.uniform(-0.01, 0.01), random.uniform(-0.002, 0.002), 3 * bar_half.z() + 0.002);
    const Vec3 tilt =
        Vec3(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(1.2, 1.9));
    pile->add_bar({.X_WB = at(from, tilt), .V_WB = {}}, bar_half);
    const Real first = energy(pile->par, pile->x);
    for (int k = 0; k < 1000 * resting; ++k) {
      ASSERT_TRUE(pile->run(1e-3));
      ASSERT_LT(energy(pile->par, pile->x), first + 1e-9);
    }
    EXPECT_NEAR(pile->p(1).z(), 3 * bar_half.z(), resting > 1 ? 1e-5 : 2e-3);
    EXPECT_LT(pile->kinetic(), resting > 1 ? 1e-12 : first);
  }
}

/// Half as wide as the brick: no corner of the one is above the other.
TEST(TouchingRidges, ABrickRestsOnARail) {
  for (const RestCase& c : rest_cases()) {
    const auto pile = std::make_unique<Bars>();
    add_box(pile->par, at(Vec3(0, 0, -0.01)), Vec3(0.05, 0.003, 0.01));
    pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
    set_law(pile->par, law_of(c.k, c.zeta));
    pile->add_bar({.X_WB = at(Vec3(0, 0, brick_half.z()), Vec3(0, 0, c.yaw)), .V_WB = {}}, brick_half);
    expect_to_rest(
        c, 0, [] { return 0.0; }, *pile);
    EXPECT_EQ(pile->out.contacts.num_contacts, 4u);
  }
}

/// Boxes of the world on their edges.
TEST(TouchingRidges, ABrickRestsOnTwoRidges) {
  constexpr Real half = 0.01;
  for (const RestCase& c : rest_cases()) {
    const auto pile = std::make_unique<Bars>();
    for (const Real x : {-0.006, 0.006}) {
      const Quat q = exp_so3(Vec3(0, 0, pi / 2 + (c.yaw - pi / 2) / 4)) * exp_so3(Vec3(pi / 4, 0, 0));
      add_box(pile->par, {.p = Vec3(x, 0, -std::sqrt(Real(2)) * half), .q = q}, Vec3(0.05, half, half));
    }
    pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
    set_law(pile->par, law_of(c.k, c.zeta));
    pile->add_bar({.X_WB = at(Vec3(0, 0, brick_half.z())), .V_WB = {}}, brick_half);
    expect_to_rest(
        c, 0, [] { return 0.0; }, *pile);
    EXPECT_EQ(pile->out.contacts.num_contacts, 4u);
  }
}

/// Two bricks, the spheres at their corners of this radius.
struct ThrowCase {
  Real radius, k, zeta;
};
std::ostream& operator<<(std::ostream& os, const ThrowCase& c) {
  return os << "spheres of " << c.radius << " m, k " << c.k << " N/m, " << c.zeta << " times critical";
}
std::vector<ThrowCase> throw_cases() {
  std::vector<ThrowCase> all;
  for (const Real radius : {small_radius, corner_radius})
    for (const Real k : {1e3, 1e4, 1e5, 1e6})
      for (const Real zeta : {0.0, 1.0}) all.push_back({.radius = radius, .k = k, .zeta = zeta});
  return all;
}

/// Shortly before they meet at up to 2 m/s.
std::unique_ptr<Bars> thrown(const ThrowCase& c, Random& random) {
  auto pile = std::make_unique<Bars>();
  set_law(pile->par, law_of(c.k, c.zeta));
  const Vec3 way = random.direction();
  const Real speed = random.uniform(0.1, 1.9);
  for (const Real side : {-1.0, 1.0}) {
    const Quat q = random.rotation();
    const Vec3 w = 10 * random.vector(), v = side * -0.5 * speed * way + 0.05 * random.vector();
    pile->add_bar({.X_WB = {.p = side * 0.03 * way, .q = q}, .V_WB = {.w = w, .v = v}}, brick_half, c.radius);
  }
  const auto closer = [&](Real by) {
    for (auto& body : pile->x.bodies) body.x.X_WB.p *= by;
  };
  while (overlap(pile->box(0), pile->box(1)) < -1e-4) closer(0.99);
  closer(1.02);
  return pile;
}

/// Calls f(bricks, kinetic energy and speed at first) after each step of the throws of a case, 0.03 s each.
/// Returns the number of throws in which the bricks touched.
template <class F>
int each_step(const ThrowCase& c, Random& random, F f) {
  int touched = 0;
  for (int n = 0; n < throws; ++n) {
    const auto pile = thrown(c, random);
    const Real kinetic = pile->kinetic(), speed = (pile->at(0).v_W - pile->at(1).v_W).norm();
    std::size_t contacts = 0;
    for (int k = 0; k < 30 && pile->run(pile->par.h); ++k) {
      f(*pile, kinetic, speed);
      contacts += pile->out.contacts.num_contacts;
    }
    touched += contacts > 0 ? 1 : 0;
  }
  return touched;
}

/// J: the spin of a body near another is that before the step, which drives it a little; up to 5e-7 J
/// occurred in 16 000 throws
constexpr Real from_spin = 1e-6;

TEST(TouchingRidges, ThrownBricksGainNoEnergy) {
  Random random(2);
  for (const ThrowCase& c : throw_cases()) {
    SCOPED_TRACE(::testing::Message() << c);
    Real gained = 0;
    const int touched = each_step(c, random, [&](const Bars& pile, Real kinetic, Real) {
      gained = std::max(gained, pile.kinetic() - kinetic);
    });
    std::printf("spheres of %g m, k %g N/m, %g times critical: gained %.1e J\n", c.radius, c.k, c.zeta,
                gained);
    EXPECT_LT(gained, from_spin);
    EXPECT_GE(touched, throws / 2);
  }
}

/// As deep as the spring of one contact stops them and the spheres round their corners off, plus their motion
/// in half a step.
TEST(TouchingRidges, ThrownBricksStayOutOfEachOther) {
  constexpr unsigned seeds = 10;
  Real deepest = 0;
  int num_throws = 0;
  for (unsigned seed = 2; seed < 2 + seeds; ++seed) {
    Random random(seed);
    for (const ThrowCase& c : throw_cases()) {
      SCOPED_TRACE(::testing::Message() << c);
      const int touched = each_step(c, random, [&](const Bars& pile, Real, Real speed) {
        const Real spring = speed * std::sqrt(brick_mass / 2 / c.k),
                   rounding = (std::sqrt(Real(3)) - 1) * c.radius;
        deepest = std::max(deepest, overlap(pile.box(0), pile.box(1)) - spring - rounding);
      });
      EXPECT_GE(touched, throws / 2);
      num_throws += throws;
    }
  }
  std::printf("%d throws, %.2f mm deeper than springs and rounding at most\n", num_throws, 1e3 * deepest);
  EXPECT_LT(deepest, 1e-3);
}

}  // namespace
}  // namespace godobject::test_touching_ridges
