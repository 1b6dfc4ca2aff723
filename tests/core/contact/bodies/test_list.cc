// The list of contacts between bodies: full, in order, replayed; bad parameters and inputs.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_touching_list {
namespace {

/// A heap of eight bricks has some 150 contacts.
constexpr std::size_t num_bricks = 8, few = 40, enough = 288;
template <std::size_t contacts>
using Heap = Pile<TouchingBodies<ImplicitEuler, num_bricks, PoseDevice, contacts>>;

/// Two towers of four, each brick 0.1 mm deeper in the one below than the next.
template <std::size_t contacts>
std::unique_ptr<Heap<contacts>> heap() {
  auto pile = std::make_unique<Heap<contacts>>();
  pile->add_floor();
  for (int i = 0; i < 8; ++i) {
    const int level = i / 2;
    const Real z = 0.005 + 0.0099 * level + 1e-5 * level * (level + i % 2);
    pile->add_brick({.X_WB = at(Vec3(i % 2 == 0 ? 0 : 0.04, 0.001 * level, z)), .V_WB = {}});
  }
  return pile;
}

TEST(TouchingList, KeepsTheDeepestWhenFullAndSaysSo) {
  const auto all = heap<enough>();
  all->step();
  ASSERT_FALSE(any(all->out.fault));
  const auto& near = all->w.contacts.near;
  ASSERT_GT(near.size, few);
  // by depth in the last stage's prediction, which is the first of a scene at rest
  std::vector<std::pair<Real, std::uint64_t>> by_depth;
  for (std::size_t i = 0; i < near.size; ++i) by_depth.emplace_back(-near.list[i].d, near.list[i].key);
  std::sort(by_depth.begin(), by_depth.end());
  const auto pile = heap<few>();
  pile->step();
  EXPECT_EQ(pile->out.fault, Fault::contacts_full);
  EXPECT_EQ(pile->x.tick, 1u);
  EXPECT_EQ(pile->out.contacts.num_near, few);
  const auto& kept = pile->w.contacts.near;
  ASSERT_EQ(kept.size, few);
  Real shallowest = kept.list[0].d;
  for (std::size_t i = 1; i < few; ++i) {
    EXPECT_LT(kept.list[i - 1].key, kept.list[i].key);
    shallowest = std::min(shallowest, kept.list[i].d);
  }
  std::size_t deeper = 0;
  for (const auto& [minus_d, key] : by_depth) deeper += -minus_d > shallowest + 1e-5 ? 1 : 0;
  EXPECT_LE(deeper, few);
  // once there is room again nothing is reported
  pile->par.gravity_W = Vec3(0, 0, 0);
  for (std::size_t i = 0; i < num_bricks; ++i)
    place(pile->x, i, {.X_WB = at(Vec3(0, 0, 0.1 * static_cast<Real>(i + 1))), .V_WB = {}});
  pile->step(2);
  EXPECT_EQ(pile->out.fault, Fault::none);
  EXPECT_EQ(pile->x.contacts.size, 0u);
}

/// The scratch that step() leaves has the pairs in their order, each once.
TEST(TouchingList, HasItsPairsInOrder) {
  const auto pile = heap<enough>();
  for (int n = 0; n < 300; ++n) {
    pile->step();
    ASSERT_FALSE(any(pile->out.fault)) << n;
    const auto& near = pile->w.contacts.near;
    for (std::size_t i = 1; i < near.size; ++i) ASSERT_LT(near.list[i - 1].key, near.list[i].key) << n;
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < near.size; ++i) {
      const bool is_new = i == 0 || pair_of(near.list[i - 1]) != pair_of(near.list[i]);
      pairs += is_new && near.list[i].b < num_bricks ? 1 : 0;
    }
    ASSERT_EQ(pile->w.contacts.graph.num_pairs, pairs);
  }
  EXPECT_GT(pile->x.contacts.size, few);
}

template <std::size_t contacts>
void stir(Heap<contacts>& pile) {
  const Real t = 1e-3 * static_cast<Real>(pile.x.tick + 1);
  pile.lead_to(7,
               Vec3(0.04 + 0.03 * std::sin(9 * t), 0.02 * std::sin(5 * t), 0.02 + 0.015 * std::cos(7 * t)));
  pile.step();
}
template <std::size_t contacts>
std::unique_ptr<Heap<contacts>> stirred() {
  auto pile = heap<contacts>();
  pile->hold_at(7, at(Vec3(0.04, 0, 0.035)), spring(pile->par.bodies[7].body, 300, 0.05));
  return pile;
}

/// Bit by bit, from a state in mid-run too, whatever the scratch holds.
TEST(TouchingList, IsReplayed) {
  const auto pile = stirred<enough>(), again = stirred<enough>(), elsewhere = heap<enough>();
  elsewhere->step(100);
  std::uint64_t touched = 0;
  for (int n = 0; n < 1000; ++n) {
    stir(*pile);
    stir(*again);
    if (n % 100 == 50) again->w = elsewhere->w;
    ASSERT_EQ(pile->hash(), again->hash()) << n;
    touched += pile->x.contacts.size;
  }
  EXPECT_GT(touched, 20000u);
  auto other = pile->x;
  ASSERT_GT(other.contacts.size, 0u);
  other.contacts.list[0].e += 1e-12;
  EXPECT_NE(state_hash(pile->par, other), pile->hash());
}

TEST(TouchingList, OutlivesInputsThatAreNoNumbers) {
  const auto pile = stirred<enough>(), untroubled = stirred<enough>();
  for (int n = 0; n < 200; ++n) {
    stir(*untroubled);
    const std::uint64_t before = pile->hash();
    const PoseDevice::Input good = pile->in.devices[7];
    for (const Real bad : {std::nan(""), 1e308, std::numeric_limits<Real>::infinity()}) {
      pile->in.devices[7].target.X_WD.p.z() = bad;
      pile->step();
      ASSERT_TRUE(has(pile->out.fault, Fault::input_not_finite | Fault::state_not_finite)) << bad;
      ASSERT_EQ(pile->hash(), before) << bad;
    }
    pile->in.devices[7] = good;
    stir(*pile);
    ASSERT_EQ(pile->hash(), untroubled->hash()) << n;
  }
}

/// A body with a non-finite state is reported; nothing moves, and nothing is lost once it is corrected.
TEST(TouchingList, LosesNothingToABodyThatIsNoNumber) {
  const auto pile = heap<enough>();
  pile->step(50);
  const std::uint64_t before = pile->hash();
  for (const Real bad : {std::nan(""), std::numeric_limits<Real>::infinity()})
    for (Vec3 RigidBodyState::*const member : {&RigidBodyState::v_W, &RigidBodyState::w_B}) {
      RigidBodyState& body = pile->x.bodies[3].x;
      const RigidBodyState good = body;
      (body.*member).y() = bad;
      const Vec3 p = pile->p(5);
      pile->step();
      EXPECT_EQ(pile->out.fault, Fault::state_not_finite);
      EXPECT_EQ(pile->p(5), p);
      body = good;
      ASSERT_EQ(pile->hash(), before);
    }
  RigidBodyState& body = pile->x.bodies[3].x;
  const RigidBodyState good = body;
  body.X_WB.p.x() = std::nan("");
  pile->step();
  EXPECT_EQ(pile->out.fault, Fault::state_not_finite);
  body = good;
  EXPECT_EQ(pile->hash(), before);
  const auto untroubled = heap<enough>();
  untroubled->step(51);
  pile->step();
  EXPECT_EQ(pile->hash(), untroubled->hash());
}

// Parameters.

using HeapParams = Params<TouchingBodies<ImplicitEuler, num_bricks, PoseDevice, enough>>;
template <class Change>
Invalid validated(Change change) {
  const auto pile = heap<enough>();
  change(pile->par);
  return validate(pile->par);
}

TEST(TouchingParams, AreValid) {
  EXPECT_EQ(validated([](HeapParams&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](HeapParams& par) {
              par.contacts.surfaces[1].shape = {
                  .kind = ShapeKind::capsule, .radius = 0.01, .half_length = 0.01};
            }),
            Invalid::nothing);
}

TEST(TouchingParams, NameABadSurface) {
  const auto surface = [](auto change) {
    return validated([&](HeapParams& par) { change(par.contacts.surfaces[2]); });
  };
  EXPECT_EQ(surface([](Surface& s) { s.body = num_bricks; }), Invalid::contact_surface);  // of no body
  EXPECT_EQ(surface([](Surface& s) { s.body = world; }), Invalid::contact_surface);       // after a body's
  EXPECT_EQ(surface([](Surface& s) { s.body = 5; }), Invalid::contact_surface);  // then comes body 2's
  EXPECT_EQ(surface([](Surface& s) { s.shape.half_extents.z() = 0; }), Invalid::contact_surface);
  EXPECT_EQ(surface([](Surface& s) { s.shape.X_WS.p.x() = std::nan(""); }), Invalid::contact_surface);
  EXPECT_EQ(surface([](Surface& s) { s.material = max_materials; }), Invalid::contact_surface);
  EXPECT_EQ(validated([](HeapParams& par) { par.contacts.num_surfaces = num_bricks + 3; }),
            Invalid::contact_surface);
}

/// Shapes without extents belong to the world.
TEST(TouchingParams, NameAShapeThatNoBodyCanCarry) {
  EXPECT_EQ(validated([](HeapParams& par) { par.contacts.surfaces[1].shape = {.kind = ShapeKind::plane}; }),
            Invalid::contact_surface);
}

TEST(TouchingParams, NameABadSphere) {
  EXPECT_EQ(validated([](HeapParams& par) { par.contacts.spheres[9].body = 5; }), Invalid::contact_sphere);
  EXPECT_EQ(validated([](HeapParams& par) { par.contacts.spheres[9].radius = 0; }), Invalid::contact_sphere);
  EXPECT_EQ(validated([](HeapParams& par) { par.num_bodies = 7; }), Invalid::contact_sphere);
}

}  // namespace
}  // namespace godobject::test_touching_list
