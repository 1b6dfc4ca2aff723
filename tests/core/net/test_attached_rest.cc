// Attachments of nets: conservation in flight, carried weight, displayed wrench, and rejected parameters.
#include <gtest/gtest.h>

#include "tests/core/net/usual_scene.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_net_attached_rest {
namespace {

template <class I>
using Scene_ = AttachedNetScene<I>;

/// Returns a tube of 48 nodes on a free body, eight of its nodes sewn to a second body, all flying.
template <class I>
std::unique_ptr<Running<Scene_<I>>> in_flight(unsigned seed, int max_iterations) {
  Random random(seed);
  auto run = std::make_unique<Running<Scene_<I>>>();
  auto& par = run->par;
  par.num_bodies = 2;
  par.net.max_iterations = max_iterations;
  const Real k = random.log_uniform(30, 300), m = random.log_uniform(1e-4, 1e-3),
             k_a = (seed % 2 == 0 ? 0.1 : 0.01) * k;
  add_tube(par,
           {.m = m,
            .k = k,
            .g = 0.1 * std::sqrt(k * m),
            .k_a = k_a,
            .g_a = 0.1 * std::sqrt(k_a * m),
            .carrier = 0},
           8, 6, 0.01);
  const Twist V{.w = 5 * random.vector(), .v = random.vector()};
  const Pose X{.p = 0.1 * random.vector(), .q = random.rotation()};
  for (std::size_t i = 0; i < 2; ++i) {
    par.bodies[i].body = rigid_body(0.02, random.inertia(Vec3(4e-6, 5e-6, 7e-6)));
    const Vec3 r = static_cast<Real>(i) * (X.q * Vec3(0, 0, 0.03));
    place(run->x, i, {.X_WB = {.p = X.p + r, .q = X.q}, .V_WB = {.w = V.w, .v = V.v + V.w.cross(r)}});
    run->in.devices[i] = {};
  }
  place_net(par.net, run->x);
  const Real k_s = random.log_uniform(30, 3000);
  for (std::uint32_t n = 40; n < 48; ++n) attach(par, run->x, n, 1, k_s, 0.1 * std::sqrt(k_s * m));
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    run->x.net.nodes[n].p_W += 1e-3 * random.vector();
    run->x.net.nodes[n].v_W += 0.1 * random.vector();
  }
  EXPECT_EQ(validate(par), Invalid::nothing);
  return run;
}

/// Momentum of bodies and nodes about the origin, and a bound of its size.
struct Momentum {
  Vec3 P = Vec3::Zero(), L = Vec3::Zero();
  Real P_scale = 0, L_scale = 0;

  template <class S>
  explicit Momentum(const Running<S>& run) {
    const auto add = [&](Real m, const Vec3& p, const Vec3& v) {
      P += m * v;
      L += m * p.cross(v);
      P_scale += m * v.norm();
      L_scale += m * p.norm() * v.norm();
    };
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      const RigidBodyState& body = run.x.bodies[i].x;
      add(run.par.bodies[i].body.m, body.X_WB.p, body.v_W);
      const Vec3 spin = body.X_WB.q * (run.par.bodies[i].body.I_B * body.w_B);
      L += spin;
      L_scale += spin.norm();
    }
    for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
      add(run.par.net.nodes[n].m, run.x.net.nodes[n].p_W, run.x.net.nodes[n].v_W);
  }
};

template <class I>
void expect_momenta_kept() {
  Real linear = 0, angular = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const int cap : {1, 2, 12}) {
      auto run = in_flight<I>(seed, cap);
      const Momentum first(*run);
      for (int n = 0; n < 500; ++n) {
        run->step();
        ASSERT_EQ(run->out.fault, Fault::none);
        const Momentum now(*run);
        linear = std::max(linear, (now.P - first.P).norm() / first.P_scale);
        angular = std::max(angular, (now.L - first.L).norm() / first.L_scale);
      }
    }
  }
  std::printf("%s: linear momentum within %.1e, angular momentum within %.1e of what they were\n", I::name,
              linear, angular);
  EXPECT_LT(linear, 1e-11);
  EXPECT_LT(angular, 1e-11);
}

TEST(NetAttached, MomentaAreKeptHoweverFewTheIterations) {
  expect_momenta_kept<ImplicitEuler>();
  expect_momenta_kept<TrBdf2>();
}

/// A sheet on a body that the hand holds, or in the world, held at its corners. A free body of 30 g is sewn
/// under its middle, and swings until it rests.
template <class I>
struct Hanging : Running<Scene_<I>> {
  static constexpr Real k = 500, k_d = 200, k_s = 200, m = 0.03;  // N/m: coupling, feedback, attachments; kg
  static constexpr std::array<std::uint32_t, 4> middle{16, 17, 18, 24};

  explicit Hanging(std::size_t carrier, bool tight = true) {
    auto& par = this->par;
    par.gravity_W = Vec3(0.5, 0, -9.81);
    par.num_bodies = 2;
    par.bodies[0].body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
    par.bodies[0].coupling = {.k = k, .g = 15, .k_r = 1, .g_r = 0.02};
    par.bodies[0].feedback.gains = {.k = k_d};
    par.bodies[0].feedback.max_force = par.bodies[0].feedback.max_torque = 100;
    par.bodies[0].feedback.max_force_rate = par.bodies[0].feedback.max_torque_rate = 1e6;
    par.bodies[0].device.rise = 0;
    par.bodies[1].body = rigid_body(m, Vec3(3e-6, 4e-6, 5e-6).asDiagonal());
    place(this->x, 1, {.X_WB = {.p = Vec3(0, 0, -0.01)}, .V_WB = {}});
    this->in.devices[1] = {};
    add_sheet(par, {.m = 1e-3, .k = 60, .g = 0.12, .g_a = 0.1, .carrier = carrier}, 7, 7, 0.01);
    for (const std::size_t corner : {0u, 6u, 42u, 48u}) par.net.nodes[corner].k = 500;
    place_net(par.net, this->x);
    for (const std::uint32_t n : middle) attach(par, this->x, n, 1, k_s, 0.3);
    engage_at(this->x, 0, {});
    if (tight) {
      par.net.max_iterations = 3000;
      par.net.tolerance = 1e-14 / (par.h * par.h);
    }
    EXPECT_EQ(validate(par), Invalid::nothing);
  }
  /// Force of attachment a on its body, N.
  Vec3 pull(const NetAttachment& one) const {
    const Pose& X_WB = this->x.bodies[one.body].x.X_WB;
    return one.k * (this->x.net.nodes[one.node].p_W - X_WB.p - X_WB.q * one.p_B);
  }
};

template <class I>
void expect_equilibrium(std::size_t carrier, bool tight) {
  auto run = std::make_unique<Hanging<I>>(carrier, tight);
  const auto& par = run->par;
  run->step(8000);
  ASSERT_EQ(run->out.fault, Fault::none);
  const RigidBodyState& body = run->x.bodies[1].x;
  const Vec3 weight = Hanging<I>::m * par.gravity_W;
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero(), of_anchors = Vec3::Zero();
  for (const NetAttachment& one : par.net.attachments) {
    force += run->pull(one);
    torque += (body.X_WB.q * one.p_B).cross(run->pull(one));
  }
  // anchors carry the weight of all bodies below
  Vec3 all = weight;
  for (std::size_t n = 0; n < par.net.num_nodes; ++n) {
    const NetNode& node = par.net.nodes[n];
    const Pose X_WB = carrier == world ? Pose{} : run->body().X_WB;
    of_anchors += node.k * (X_WB.p + X_WB.q * node.p_B - run->x.net.nodes[n].p_W);
    all += node.m * par.gravity_W;
  }
  const Real close = 1e-6, w = weight.norm();
  std::printf(
      "%s, %s: sags by %.1f mm; weight missed by %.1e, torque %.1e of it at 1 cm, anchors %.1e; %.1e m/s\n",
      I::name, tight ? "many iterations" : "default iterations", -1e3 * (body.X_WB.p.z() + 0.01),
      (force + weight).norm() / w, torque.norm() / (0.01 * w), (of_anchors + all).norm() / all.norm(),
      body.v_W.norm());
  EXPECT_LT(body.X_WB.p.z(), -0.015);
  EXPECT_LT((force + weight).norm(), close * w);
  EXPECT_LT(torque.norm(), close * 0.01 * w);
  EXPECT_LT((of_anchors + all).norm(), close * all.norm());
  if (carrier == world) return;
  // (8)  the hand carries all of it, and the displayed wrench is its share
  const Vec3 coupling = Hanging<I>::k * (Vec3::Zero() - run->body().X_WB.p),
             on_tool = all + 0.1 * par.gravity_W;
  EXPECT_LT((coupling + on_tool).norm(), close * on_tool.norm());
  EXPECT_LT((run->out.bodies[0].feedback.F_D.f * (Hanging<I>::k / Hanging<I>::k_d) - on_tool).norm(),
            close * on_tool.norm());
}

TEST(NetAttached, ABodyHangsWhereItsWeightIsBorneAndTheHandFeelsIt) {
  for (const std::size_t carrier : {world, std::size_t{0}}) {
    for (const bool tight : {true, false}) {
      expect_equilibrium<ImplicitEuler>(carrier, tight);
      expect_equilibrium<TrBdf2>(carrier, tight);
    }
  }
}

/// The tool that a net is attached to, rather than its carrier, feels it too; on a joint, the joint bears it.
template <class I>
void expect_hand_and_joint_to_bear() {
  auto run = std::make_unique<Hanging<I>>(world);
  auto& par = run->par;
  par.bodies[1].joint.kind = JointKind::hinge;
  par.bodies[1].joint.parent = 0;
  par.bodies[1].joint.P = {.p = Vec3(0, 0, -0.01), .R = turn_from_z(Vec3::UnitY()).toRotationMatrix()};
  par.bodies[1].joint.C.R = par.bodies[1].joint.P.R;
  ASSERT_EQ(validate(par), Invalid::nothing);
  run->in.devices[0].target.X_WD.p = Vec3(0, 0, 0.01);
  run->step(8000);
  ASSERT_EQ(run->out.fault, Fault::none);
  Vec3 pull = Vec3::Zero();
  for (const NetAttachment& one : par.net.attachments) pull += run->pull(one);
  const Vec3 weight = Hanging<I>::m * par.gravity_W, on_tool = pull + weight + 0.1 * par.gravity_W;
  const Vec3 shown = run->out.bodies[0].feedback.F_D.f * (Hanging<I>::k / Hanging<I>::k_d);
  EXPECT_GT(pull.norm(), 0.05);
  EXPECT_LT((shown - on_tool).norm(), 1e-6 * on_tool.norm());
  EXPECT_LT((run->out.bodies[1].joint.F_C.f + pull + weight).norm(), 1e-6 * on_tool.norm());
}

TEST(NetAttached, AJointBearsWhatPullsItsBody) {
  expect_hand_and_joint_to_bear<ImplicitEuler>();
  expect_hand_and_joint_to_bear<TrBdf2>();
}

/// Nodes do not touch bodies that they are attached to, and touch all others.
TEST(NetAttached, NodesDoNotTouchWhatTheyAreAttachedTo) {
  for (const bool sewn : {true, false}) {
    auto run = std::make_unique<Hanging<ImplicitEuler>>(world);
    auto& par = run->par;
    for (std::size_t n = 0; n < par.net.num_nodes; ++n)
      par.net.nodes[n].radius = n == 16 || n == 30 ? 2e-3 : 0;
    par.contacts.spheres[par.contacts.num_spheres++] = {.body = 1, .radius = 0.03};
    par.contacts.laws[0][0] = {.k = 100, .c = 0.05};
    if (!sewn) par.net.attachments.size = 0;
    ASSERT_EQ(validate(par), Invalid::nothing);
    run->step();
    EXPECT_EQ(run->out.net.num_near, sewn ? 1u : 2u);
  }
}

template <class I>
void expect_no_allocation() {
  auto run = std::make_unique<Hanging<I>>(0, false), again = std::make_unique<Hanging<I>>(0, false),
       other = std::make_unique<Hanging<I>>(world, false);
  other->step(20);
  again->w = other->w;  // a scratch that another scene has used
  AllocationGuard guard;
  run->step(100);
  guard.disarm();
  const long calls = AllocationGuard::works() ? guard.calls() : 0L;
  EXPECT_EQ(calls, 0) << guard.report();
  again->step(100);
  EXPECT_EQ(run->hash(), again->hash());
}

TEST(NetAttached, NeitherAllocatesNorDependsOnWhatWasBefore) {
  expect_no_allocation<ImplicitEuler>();
  expect_no_allocation<TrBdf2>();
}

TEST(NetAttached, IsCheckedBeforeTheFirstStep) {
  const auto validated = [](auto change) {
    auto run = std::make_unique<Hanging<TrBdf2>>(0, false);
    change(run->par.net.attachments);
    return validate(run->par);
  };
  using All = NetAttachments<32>;
  const Real nan = std::numeric_limits<Real>::quiet_NaN(), infinity = std::numeric_limits<Real>::infinity();
  EXPECT_EQ(validated([](All&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](All& all) { all.list[0].body = world; }), Invalid::nothing);
  EXPECT_EQ(validated([](All& all) { all.list[1].node = all.list[0].node; }), Invalid::nothing)
      << "two at a node";
  const auto refused = [&](const char* what, auto change) {
    EXPECT_EQ(validated(change), Invalid::net_attachment) << what;
  };
  for (const Real bad : {-1.0, nan, infinity}) {
    refused("stiffness", [&](All& all) { all.list[2].k = bad; });
    refused("damping", [&](All& all) { all.list[2].g = bad; });
  }
  for (const Real bad : {nan, infinity}) refused("place", [&](All& all) { all.list[1].p_B.y() = bad; });
  refused("more than there is room for", [](All& all) { all.size = 33; });
  refused("no such node", [](All& all) { all.list[3].node = 49; });
  refused("no such body", [](All& all) { all.list[3].body = 2; });
  refused("its carrier", [](All& all) { all.list[3].body = 0; });
  refused("not in order", [](All& all) { std::swap(all.list[0], all.list[3]); });
}

// A net without room for attachments has nothing of them.
static_assert(std::is_empty_v<NetAttachments<0>>);
static_assert(sizeof(NetParams<8, 8>) < sizeof(NetParams<8, 8, 1>));
static_assert(std::is_empty_v<NetStage<MassSpringNet<8, 8, 8>, 1>::NumAttachments>);
static_assert(sizeof(State<AttachedNetScene<TrBdf2>>) == sizeof(State<JointedNetScene<TrBdf2>>));

}  // namespace
}  // namespace godobject::test_net_attached_rest
