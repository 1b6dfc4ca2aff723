// Forces in the outputs of scenes with nets. With gravity, the forces on bodies, joints and single nodes
// equal the change of momentum in a step. Also in impacts, and for any number of iterations of nets.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_forces {
namespace {

constexpr Real gravity = 9.81;  // m/s^2

enum class Kind : std::uint8_t { carried, floating, attached, jointed };

/// A net on the first body or in the world, thrown with free balls at each other and at a floor. Nothing is
/// held.
template <class I>
struct Thrown : Running<AttachedNetScene<I>> {
  static constexpr std::size_t num_bodies = 3;

  Thrown(Kind kind, unsigned seed) {
    Random random(seed);
    auto& par = this->par;
    par.h = random.log_uniform(2e-4, 3e-3);
    par.num_bodies = num_bodies;
    const bool has_floor = random.integer(0, 3) > 0;
    if (has_floor) par.gravity_W = Vec3(0, 0, -gravity);
    for (std::size_t i = 0; i < num_bodies; ++i) {
      const Real m = random.log_uniform(5e-3, 0.2), radius = random.uniform(0.006, 0.012);
      par.bodies[i].body = rigid_body(m, Mat3(0.4 * m * radius * radius * Mat3::Identity()));
      par.contacts.spheres[par.contacts.num_spheres++] = {.body = i, .radius = radius};
      this->in.devices[i] = {};
    }
    add_net(kind, random);
    place_all(kind, random);
    if (has_floor)
      par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -0.03)}}};
    par.contacts.laws[0][0] = {.k = random.log_uniform(100, 1e5),
                               .c = random.uniform(0, 1),
                               .mu = random.uniform(0, 0.9),
                               .k_t = random.log_uniform(100, 1e5),
                               .c_t = 0.1};
    const int caps[] = {1, 2, 4, 12};
    par.net.max_iterations = caps[random.integer(0, 3)];
    EXPECT_EQ(validate(par), Invalid::nothing);
  }

  void add_net(Kind kind, Random& random) {
    const bool on_body = kind == Kind::carried || kind == Kind::jointed;
    const Real m = random.log_uniform(1e-4, 2e-3), k = random.log_uniform(20, 500);
    Stuff stuff{.m = m, .k = k, .g = 0.1 * std::sqrt(k * m), .g_a = 0.01, .radius = 2e-3};
    if (on_body) {
      stuff.carrier = 0;
      stuff.k_a = random.uniform(0.02, 0.5) * k;
    }
    if (random.integer(0, 1) == 0) add_sheet(this->par, stuff, 6, 5, 0.008);
    else add_tube(this->par, stuff, 6, 5, 0.008);
  }

  void place_all(Kind kind, Random& random) {
    auto& par = this->par;
    const Vec3 around[] = {Vec3(0, 0, 0.01), Vec3(0.02, 0.01, 0.045), Vec3(-0.02, 0.005, 0.05)};
    for (std::size_t i = 0; i < num_bodies; ++i)
      place(this->x, i,
            {.X_WB = {.p = around[i], .q = random.rotation()},
             .V_WB = {.w = 5 * random.vector(), .v = -20 * around[i] + 0.1 * random.vector()}});
    if (kind == Kind::jointed) {
      auto& joint = par.bodies[1].joint;
      joint.kind = random.integer(0, 1) == 0 ? JointKind::hinge : JointKind::ball;
      joint.parent = 0;
      joint.P.p = Vec3(0.015, 0, 0);
      joint.C.p = Vec3(-0.012, 0, 0);
      const RigidBodyState& on = this->x.bodies[0].x;
      place(this->x, 1,
            {.X_WB = {.p = on.X_WB.p + on.X_WB.q * Vec3(0.027, 0, 0), .q = on.X_WB.q}, .V_WB = {}});
      for (const std::size_t i : {0, 1})
        this->x.bodies[i].x.w_B = Vec3::Zero(), this->x.bodies[i].x.v_W = Vec3(0.1, 0, -0.6);
    }
    place_net(par.net, this->x);
    if (kind != Kind::attached) return;
    for (const std::uint32_t n : {0u, 3u}) attach(par, this->x, n, 0, random.log_uniform(5, 200), 0.02);
    for (const std::uint32_t n : {26u, 29u}) attach(par, this->x, n, 1, random.log_uniform(5, 200), 0.02);
  }
};

/// Momenta of groups that exchange forces which are not outputs: bodies with their carried nodes, and nets
/// with the bodies that they are attached to. The last one is that of nodes of the world.
template <class R>
struct Momenta {
  static constexpr std::size_t of_world = R::num_bodies;
  std::array<Vec3, of_world + 1> P;
  std::array<Real, of_world + 1> m{};

  explicit Momenta(const R& run) {
    P.fill(Vec3::Zero());
    for (std::size_t i = 0; i < of_world; ++i) add(i, run.par.bodies[i].body.m, run.x.bodies[i].x.v_W, run);
    for (std::size_t n = 0; n < run.par.net.num_nodes; ++n)
      add(carrier(n, run), run.par.net.nodes[n].m, run.x.net.nodes[n].v_W, run);
  }
  static std::size_t carrier(std::size_t n, const R& run) {
    return run.par.net.nodes[n].body == world ? of_world : run.par.net.nodes[n].body;
  }
  static std::size_t group(std::size_t i, const R& run) {
    for (const NetAttachment& one : run.par.net.attachments)
      if (one.body == i) return of_world;
    return i;
  }
  void add(std::size_t i, Real mass, const Vec3& v, const R& run) {
    P[group(i, run)] += mass * v;
    m[group(i, run)] += mass;
  }
};

/// True for bodies supported by the floor, by contacts or attachments of a chain of bodies and nets. Others
/// have no contact that could carry the residual momentum of all.
template <class R>
std::array<bool, R::num_bodies> bear_on_floor(const R& run) {
  constexpr std::size_t of_world = R::num_bodies, floor = of_world + 1;
  std::array<std::size_t, of_world + 2> chain;
  for (std::size_t i = 0; i < chain.size(); ++i) chain[i] = i;
  const auto join = [&](std::size_t a, std::size_t b) {
    const std::size_t from = chain[a], to = chain[b < of_world ? b : floor];
    std::replace(chain.begin(), chain.end(), from, to);
  };
  // one that does not touch the floor may have been out of reach in the first stage
  const auto join_near = [&](std::size_t a, const NearContact& near) {
    if (near.b < of_world || near.d > 0) join(a, near.b);
  };
  for (std::size_t k = 0; k < run.w.contacts.near.size; ++k)
    join_near(run.w.contacts.near.list[k].a, run.w.contacts.near.list[k]);
  for (std::size_t k = 0; k < run.w.contacts.net.near.size; ++k)
    join_near(Momenta<R>::carrier(run.w.contacts.net.near.list[k].a, run), run.w.contacts.net.near.list[k]);
  for (const NetAttachment& one : run.par.net.attachments) join(of_world, one.body);
  std::array<bool, of_world> bear;
  for (std::size_t i = 0; i < of_world; ++i)
    bear[i] = chain[i] == chain[floor] && run.par.bodies[i].joint.kind == JointKind::free;
  return bear;
}

struct Off {
  Real momentum = 0, listed = 0, given = 0;
  int by_net = 0, stopped = 0, bearing = 0;
  std::array<bool, 3> bore{};  // in the step before, whose last stage TR-BDF2 goes on from
};

/// Takes a step and adds its error.
template <class R>
void take(R& run, Off& off) {
  const Momenta<R> before(run);
  run.step();
  ASSERT_FALSE(any(run.out.fault));
  const Momenta<R> after(run);
  constexpr std::size_t of_world = Momenta<R>::of_world;
  const Real h = run.par.h;
  std::array<Vec3, of_world + 1> J;
  std::array<Vec3, of_world> listed;
  listed.fill(Vec3::Zero());
  Real largest = 0;
  for (std::size_t g = 0; g <= of_world; ++g) {
    J[g] = after.P[g] - before.P[g] - h * after.m[g] * run.par.gravity_W;
    largest = std::max(largest, after.m[g] * h * gravity);
  }
  const auto act = [&](std::size_t i, const Vec3& F_W) {
    J[Momenta<R>::group(i, run)] -= h * F_W;
    largest = std::max(largest, h * F_W.norm());
  };
  for (std::size_t i = 0; i < of_world; ++i) {
    act(i, run.out.bodies[i].contact.F_W.f);
    const auto& joint = run.par.bodies[i].joint;
    if (joint.kind == JointKind::free) continue;
    act(i, run.out.bodies[i].joint.F_C.f);
    act(joint.parent, -run.out.bodies[i].joint.F_C.f);
  }
  const auto add = [&](const auto& forces, bool of_nodes) {
    for (std::size_t k = 0; k < forces.size; ++k) {
      const ContactForce& one = forces.list[k];
      if (of_nodes) act(Momenta<R>::carrier(one.a, run), one.F_W);
      else listed[one.a] += one.F_W;
      if (one.b < of_world) listed[one.b] -= one.F_W;
    }
  };
  add(run.w.means.contacts, false);
  add(run.w.means.of_nodes, true);
  for (const Vec3& missing : J) off.momentum = std::max(off.momentum, missing.norm() / largest);
  const auto bear = bear_on_floor(run);
  for (std::size_t i = 0; i < of_world; ++i)
    if (bear[i] && off.bore[i]) {
      ++off.bearing;
      off.listed = std::max(off.listed, h * (run.out.bodies[i].contact.F_W.f - listed[i]).norm() / largest);
    }
  off.bore = bear;
  off.given = std::max(off.given, largest);
  off.by_net += run.out.net.num_contacts > 0 ? 1 : 0;
  off.stopped += run.out.net.is_stopped ? 1 : 0;
}

template <class I>
void forces_are_momentum(Kind kind) {
  Real momentum = 0, listed = 0;
  int steps_of_nets = 0, stopped = 0, bearing = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto run = std::make_unique<Thrown<I>>(kind, seed);
    Off off;
    for (int n = 0; n < 150; ++n) take(*run, off);
    EXPECT_LT(off.momentum, 1e-9) << I::name << ", seed " << seed;
    EXPECT_LT(off.listed, 1e-9) << I::name << ", seed " << seed;
    momentum = std::max(momentum, off.momentum);
    listed = std::max(listed, off.listed);
    steps_of_nets += off.by_net;
    stopped += off.stopped;
    bearing += off.bearing;
  }
  std::printf(
      "%s: %d steps in which nodes touch, %d stopped at the most iterations; momentum off by %.1e, "
      "single forces by %.1e of the largest impulse\n",
      I::name, steps_of_nets, stopped, momentum, listed);
  EXPECT_GT(steps_of_nets, 300);
  EXPECT_GT(stopped, 300);
  EXPECT_GT(bearing, 300);
}

TEST(NetForces, OfANetOnABodyAreMomentum) {
  forces_are_momentum<ImplicitEuler>(Kind::carried);
  forces_are_momentum<TrBdf2>(Kind::carried);
}
TEST(NetForces, OfANetThatFloatsAreMomentum) {
  forces_are_momentum<ImplicitEuler>(Kind::floating);
  forces_are_momentum<TrBdf2>(Kind::floating);
}
TEST(NetForces, OfANetThatIsAttachedAreMomentum) {
  forces_are_momentum<ImplicitEuler>(Kind::attached);
  forces_are_momentum<TrBdf2>(Kind::attached);
}
TEST(NetForces, OfANetOnAToolOnJointsAreMomentum) {
  forces_are_momentum<ImplicitEuler>(Kind::jointed);
  forces_are_momentum<TrBdf2>(Kind::jointed);
}

}  // namespace
}  // namespace godobject::test_net_forces
