// The step of a scene with a net: no allocation, equal runs, reported capacities, rejected parameters, and no
// storage in a scene without.
#include <gtest/gtest.h>

#include "tests/core/net/random_net.h"
#include "tests/core/net/usual_scene.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_net_step {
namespace {

template <class I>
void expect_no_allocation() {
  for (unsigned seed = 0; seed < 2 * num_ordeals; ++seed) {
    auto net = std::make_unique<RandomNet<I>>(seed);
    AllocationGuard guard;
    for (int n = 0; n < 100; ++n) {
      net->lead();
      net->step();
    }
    guard.disarm();
    EXPECT_EQ(guard.calls(), 0) << "seed " << seed << ": " << guard.report();
  }
}

TEST(NetStep, NeitherAllocatesNorAsksTheSystem) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  expect_no_allocation<ImplicitEuler>();
  expect_no_allocation<TrBdf2>();
}

/// In a scratch that another scene has used before.
template <class I>
std::uint64_t hash_after(unsigned seed, unsigned before) {
  auto net = std::make_unique<RandomNet<I>>(seed), other = std::make_unique<RandomNet<I>>(before);
  for (int n = 0; n < 20; ++n) {
    other->lead();
    other->step();
  }
  net->w = other->w;
  for (int n = 0; n < 100; ++n) {
    net->lead();
    net->step();
  }
  return net->hash();
}

TEST(NetStep, IsTheSameInEqualRuns) {
  for (unsigned seed = 0; seed < 3 * num_ordeals; ++seed) {
    EXPECT_EQ(hash_after<ImplicitEuler>(seed, seed), hash_after<ImplicitEuler>(seed, seed + 5))
        << "seed " << seed;
    EXPECT_EQ(hash_after<TrBdf2>(seed, seed), hash_after<TrBdf2>(seed, seed + 5)) << "seed " << seed;
  }
}

TEST(NetStep, TellsTheStatesOfNodesApart) {
  auto net = std::make_unique<RandomNet<TrBdf2>>(1);
  const std::uint64_t before = net->hash();
  net->x.net.nodes[3].p_W.z() += 1e-12;
  EXPECT_NE(net->hash(), before);
}

using Crowded = NetScene<TrBdf2, 1, 64, 400, 8>;

/// A sheet that is let down on a plane: `nodes` of it touch.
template <class S>
std::unique_ptr<Running<S>> sheet_on_a_plane(std::uint32_t nx, std::uint32_t ny) {
  auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  add_sheet(par, {.m = 1e-4, .k = 50, .g = 0.02, .k_a = 5, .g_a = 0.01, .radius = 2e-3}, nx, ny, 0.01);
  par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
  par.contacts.laws[0][0] = {.k = 100, .c = 0.05};
  place_net(par.net, run->x);
  run->in.devices[0] = {};
  return run;
}

TEST(NetStep, SaysWhenContactsHaveNoRoom) {
  const auto small = sheet_on_a_plane<Crowded>(2, 3), large = sheet_on_a_plane<Crowded>(3, 4);
  ASSERT_EQ(validate(small->par), Invalid::nothing);
  Fault of_small = Fault::none, of_large = Fault::none;
  for (int n = 0; n < 300; ++n) {
    small->step();
    of_small |= small->out.fault;
    large->step();
    of_large |= large->out.fault;
  }
  EXPECT_EQ(of_small, Fault::none);
  EXPECT_EQ(small->out.net.num_near, 6u);
  EXPECT_TRUE(has(of_large, Fault::contacts_full));
  EXPECT_FALSE(has(of_large, Fault::state_not_finite));
  EXPECT_LE(large->out.net.num_near, 8u);
}

using Large = NetScene<TrBdf2, 1, 1024, 4096, 512>;

/// 1024 nodes on a plane, of which 512 touch: as many contacts as there is room for; then all of them: more.
TEST(NetStep, NeitherAllocatesWhenContactsAreFull) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  for (const bool too_many : {false, true}) {
    const auto run = sheet_on_a_plane<Large>(32, 32);
    for (std::size_t n = 0; n < Large::Net::max_contacts && !too_many; ++n) run->par.net.nodes[n].radius = 0;
    ASSERT_EQ(validate(run->par), Invalid::nothing);
    Fault faults = Fault::none;
    std::size_t most_near = 0, most_contacts = 0;
    AllocationGuard guard;
    for (int n = 0; n < 100; ++n) {
      run->step();
      faults |= run->out.fault;
      most_near = std::max(most_near, run->out.net.num_near);
      most_contacts = std::max(most_contacts, run->out.net.num_contacts);
    }
    guard.disarm();
    EXPECT_EQ(guard.calls(), 0) << guard.report();
    EXPECT_EQ(most_near, Large::Net::max_contacts);
    EXPECT_GT(most_contacts, Large::Net::max_contacts / 2);
    EXPECT_EQ(faults, too_many ? Fault::contacts_full : Fault::none);
  }
}

/// The step was taken, and reports its result.
TEST(NetStep, ShowsTheForceWhenContactsHaveNoRoom) {
  auto run = std::make_unique<Running<JointedNetScene<ImplicitEuler>>>();
  auto& par = run->par;
  auto& tool = par.bodies[0];
  tool.body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
  tool.coupling = {.k = 1000, .g = 20, .k_r = 1, .g_r = 0.02};
  tool.feedback.gains = {.k = 1000};
  tool.feedback.max_force = tool.feedback.max_torque = 100;
  tool.feedback.max_force_rate = tool.feedback.max_torque_rate = 1e6;
  tool.device.rise = 0;
  add_sheet(par, {.m = 1e-4, .k = 50, .g = 0.02, .k_a = 50, .g_a = 0.05, .radius = 2e-3, .carrier = 0}, 8, 8,
            0.01);
  for (int k = 0; k < 4; ++k)  // 64 nodes on each of them: as many contacts as there is room for
    par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
  add_node(par, {.m = 1e-4, .k_a = 50, .g_a = 0.05, .radius = 2e-3}, Vec3(0.2, 0, -0.01));  // one too many
  put_in_order(par.net);
  par.contacts.laws[0][0] = {.k = 100, .c = 0.05};
  place_net(par.net, run->x);
  engage_at(run->x, 0, {});
  run->in.devices[0].target.X_WD.p.z() = -0.02;
  ASSERT_EQ(validate(par), Invalid::nothing);
  run->step(300);
  EXPECT_EQ(run->out.fault, Fault::contacts_full);
  EXPECT_EQ(run->x.tick, 300u);
  EXPECT_GT(run->out.bodies[0].feedback.F_D.f.z(), 1);
  EXPECT_NEAR(run->out.bodies[0].feedback.F_D.f.z(),
              1000 * (run->body().X_WB.p.z() - run->in.devices[0].target.X_WD.p.z()), 1e-6);
}

/// A sheet that is thrown at an obstacle thinner than its way in a step does not come through.
TEST(NetStep, NodesDoNotPassThinObstacles) {
  Random random(9);
  for (int k = 0; k < 40; ++k) {
    auto run = std::make_unique<Running<NetScene<ImplicitEuler>>>();
    auto& par = run->par;
    par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
    const Real thick = random.log_uniform(1e-4, 2e-3), v = random.uniform(1, 5), radius = 1e-3;
    ShapeParams shape{.kind = ShapeKind::box, .half_extents = Vec3(1, 1, thick)};
    if (k % 2 == 1)
      shape = {.kind = ShapeKind::capsule,
               .X_WS = {.q = turn_from_z(Vec3::UnitX())},
               .radius = thick,
               .half_length = 1};
    par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = shape};
    par.contacts.laws[0][0] = {.k = 1000, .c = 0.1};
    const Real start = 0.02 + random.uniform(0, v * par.h);
    add_node(par, {.m = 1e-4, .radius = radius}, Vec3(0, 0, start));
    add_node(par, {.m = 1e-4, .radius = radius}, Vec3(0.01, 0, start));
    add_spring(par, {.k = 100, .g = 0.01}, 0, 1);
    put_in_order(par.net);
    place_net(par.net, run->x);
    for (std::size_t n = 0; n < 2; ++n) run->x.net.nodes[n].v_W = Vec3(0, 0, -v);
    run->in.devices[0] = {};
    ASSERT_EQ(validate(par), Invalid::nothing);
    run->step(100);
    for (std::size_t n = 0; n < 2; ++n)
      EXPECT_GT(run->x.net.nodes[n].p_W.z(), 0)
          << (k % 2 == 1 ? "capsule " : "box ") << thick << " m, " << v << " m/s";
  }
}

/// A residual below the tolerance does not cause a second solve of the springs.
TEST(NetStep, AtRestTakesSpringsOnce) {
  for (const unsigned seed : {1u, 3u, 6u, 20u, 24u, 26u}) {
    auto net = std::make_unique<RandomNet<ImplicitEuler>>(seed, static_cast<int>(Ordeal::held));
    for (int n = 0; n < 1000; ++n) net->step_and_watch();
    for (int n = 0; n < 100; ++n) {
      net->step_and_watch();
      ASSERT_FALSE(net->out.net.majorised) << "seed " << seed << ": " << net->of.text();
    }
  }
}

/// A box on a body that is turned has its faces turned.
TEST(NetStep, NodesTouchABoxAsItsBodyIsTurned) {
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    auto run = std::make_unique<Running<NetScene<ImplicitEuler>>>();
    auto& par = run->par;
    par.bodies[0].body = rigid_body(1, Mat3(1e-3 * Mat3::Identity()));
    const Quat q = random.rotation(), on_body = random.rotation();
    place(run->x, 0, {.X_WB = {.p = random.vector(), .q = q}, .V_WB = {}});
    const Pose X_BS{.p = 0.1 * random.vector(), .q = on_body};
    par.contacts.surfaces[par.contacts.num_surfaces++] = {
        .body = 0, .shape = {.kind = ShapeKind::box, .X_WS = X_BS, .half_extents = Vec3(0.03, 0.02, 0.01)}};
    par.contacts.laws[0][0] = {.k = 100};
    const Vec3 n_W = q * on_body * Vec3::UnitZ();
    const Vec3 p_W = run->body().X_WB.p + q * X_BS.p + 0.0115 * n_W;
    add_node(par, {.m = 1e-3, .radius = 2e-3}, p_W);
    put_in_order(par.net);
    place_net(par.net, run->x);
    run->in.devices[0] = {};
    ASSERT_EQ(validate(par), Invalid::nothing);
    run->step(5);
    ASSERT_EQ(run->x.net.contacts.size, 1u);
    EXPECT_LT((run->x.net.contacts.list[0].n_W.vec() - n_W).norm(), 1e-3);
  }
}

TEST(NetStep, IsCheckedBeforeTheFirst) {
  const auto validated = [](auto change) {
    auto run = sheet_on_a_plane<NetScene<TrBdf2>>(3, 3);
    change(run->par.net);
    return validate(run->par);
  };
  using Net = NetParams<65, 400>;
  const Real nan = std::numeric_limits<Real>::quiet_NaN(), infinity = std::numeric_limits<Real>::infinity();
  EXPECT_EQ(validated([](Net&) {}), Invalid::nothing);
  const auto refused = [&](const char* what, auto change) {
    EXPECT_EQ(validated(change), Invalid::net) << what;
  };
  for (const Real bad : {-1.0, nan, infinity}) {
    refused("mass", [&](Net& net) { net.nodes[4].m = bad; });
    refused("anchor's stiffness", [&](Net& net) { net.nodes[4].k = bad; });
    refused("anchor's damping", [&](Net& net) { net.nodes[4].g = bad; });
    refused("radius", [&](Net& net) { net.nodes[4].radius = bad; });
    refused("stiffness", [&](Net& net) { net.springs[2].k = bad; });
    refused("damping", [&](Net& net) { net.springs[2].g = bad; });
    refused("rest length", [&](Net& net) { net.springs[2].l_0 = bad; });
    refused("tolerance", [&](Net& net) { net.tolerance = bad; });
  }
  for (const Real bad : {nan, infinity}) refused("place", [&](Net& net) { net.nodes[4].p_B.y() = bad; });
  refused("no mass", [](Net& net) { net.nodes[0].m = 0; });
  refused("no such body", [](Net& net) { net.nodes[0].body = 1; });
  refused("carriers not in a row", [](Net& net) { net.nodes[4].body = 0; });
  refused("material", [](Net& net) { net.nodes[4].material = max_materials; });
  refused("too many nodes", [](Net& net) { net.num_nodes = 66; });
  refused("too many springs", [](Net& net) { net.num_springs = 401; });
  refused("a spring to a node that is not there", [](Net& net) { net.springs[net.num_springs - 1].j = 9; });
  refused("a spring to itself", [](Net& net) { net.springs[0].j = net.springs[0].i; });
  refused("springs not in order", [](Net& net) { std::swap(net.springs[0], net.springs[1]); });
  refused("a spring twice", [](Net& net) { net.springs[1] = net.springs[0]; });
  refused("not put in order", [](Net& net) { net.num_groups = 0; });
  refused("no iteration", [](Net& net) { net.max_iterations = 0; });
}

TEST(NetStep, SpringsArePutInOrder) {
  auto run = sheet_on_a_plane<NetScene<TrBdf2>>(3, 3);
  auto& net = run->par.net;
  std::swap(net.springs[0], net.springs[5]);
  std::swap(net.springs[2].i, net.springs[2].j);
  EXPECT_EQ(validate(run->par), Invalid::net);
  put_in_order(net);
  EXPECT_EQ(validate(run->par), Invalid::nothing);
}

// A scene without a net has no storage for it. Absence of code: freestanding/unlisted_parts.py.
struct WithoutNet {
  static constexpr std::size_t max_bodies = 4;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Joints = None;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<4, 4, 32>;
};
template <class T>
constexpr bool is_nothing = std::is_empty_v<T>;
static_assert(is_nothing<decltype(Params<WithoutNet>::net)> && is_nothing<decltype(State<WithoutNet>::net)> &&
              is_nothing<decltype(Output<WithoutNet>::net)> &&
              is_nothing<decltype(Scratch<WithoutNet>::net)> &&
              is_nothing<decltype(Scratch<WithoutNet>::contacts.net)> &&
              is_nothing<decltype(Scratch<WithoutNet>::contacts.coupled_b)>);
struct StateWithoutNet {
  std::array<BodyState<WithoutNet>, 4> bodies;
  std::uint64_t tick;
  [[no_unique_address]] ContactMemories<32> contacts;
  [[no_unique_address]] ContactForces<32> forces;  // of TR-BDF2's last stage
};
static_assert(sizeof(State<WithoutNet>) == sizeof(StateWithoutNet));
static_assert(sizeof(Output<NetScene<TrBdf2>>) > sizeof(Output<WithoutNet>));

struct OverObstacles : NetScene<TrBdf2> {
  using Contacts = FixedContacts<4, 4, 32>;
};
static_assert(Scene<NetScene<TrBdf2>> && !Scene<OverObstacles>);  // a net's bodies touch each other

}  // namespace
}  // namespace godobject::test_net_step
