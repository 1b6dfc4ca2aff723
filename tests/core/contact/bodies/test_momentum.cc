// Forces of outputs are means over the step: with gravity they equal the change of each body's momentum, in
// impacts too. Bodies that meet nothing else keep their momentum.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/drawn_piles.h"
#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_momentum {
namespace {

/// How far steps are off, each of the largest impulse on a body in it.
struct Off {
  Real momentum = 0;  // of bodies, from forces and gravity
  Real listed = 0;    // sums of the forces of single contacts, from those of bodies
  Real given = 0;     // largest momentum given by contacts in a step, N s
};

/// Takes a step and adds how far it is off. Only of scenes without couplings.
template <Scene S>
void take(Running<S>& run, Off& off) {
  constexpr std::size_t N = S::max_bodies;
  std::array<Vec3, N> J;
  Real largest = 0;
  for (std::size_t i = 0; i < run.par.num_bodies; ++i)
    J[i] = -run.par.bodies[i].body.m * (run.x.bodies[i].x.v_W + run.par.h * run.par.gravity_W);
  run.step();
  std::array<Vec3, N> listed;
  listed.fill(Vec3::Zero());
  for (std::size_t k = 0; k < run.w.means.contacts.size; ++k) {
    const ContactForce& one = run.w.means.contacts.list[k];
    listed[one.a] += one.F_W;
    if (one.b < N) listed[one.b] -= one.F_W;
  }
  Real missing = 0;
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
    const Vec3& F = run.out.bodies[i].contact.F_W.f;
    J[i] += run.par.bodies[i].body.m * run.x.bodies[i].x.v_W - run.par.h * F;
    largest = std::max({largest, run.par.h * F.norm(), run.par.bodies[i].body.m * run.par.h * earth_gravity});
    missing = std::max(missing, run.par.h * (F - listed[i]).norm());
    off.given = std::max(off.given, run.par.h * F.norm());
    if constexpr (uses<typename S::Joints>) {
      const Wrench& F_C = run.out.bodies[i].joint.F_C;
      const JointParams& joint = run.par.bodies[i].joint;
      if (joint.kind == JointKind::free) continue;
      largest = std::max(largest, run.par.h * F_C.f.norm());
      J[i] -= run.par.h * F_C.f;
      if (joint.parent != world) J[joint.parent] += run.par.h * F_C.f;
    }
  }
  for (std::size_t i = 0; i < run.par.num_bodies; ++i)
    off.momentum = std::max(off.momentum, J[i].norm() / largest);
  off.listed = std::max(off.listed, missing / largest);
}

/// Five balls in a row, the first of which hits the others.
template <class I>
void add_row(Real k, Real zeta, Real mass_ratio, Pile<FewBodies<I>>& pile) {
  constexpr Real m = 0.05, radius = 0.01;
  set_law(pile.par, {.k = k, .c = zeta * 2 * std::sqrt(k * m)});
  for (int i = 0; i < 5; ++i) {
    const Start start{.X_WB = at(Vec3(i == 0 ? 0 : 0.02 + 0.02 * i, 0, 0)),
                      .V_WB = {.w = Vec3::Zero(), .v = Vec3(i == 0 ? 1 : 0, 0, 0)}};
    const std::size_t ball = pile.add_ball(start, m * std::pow(mass_ratio, i), radius);
    pile.carry(ball, {.kind = ShapeKind::sphere, .radius = radius});
  }
}

template <class Pile>
Vec3 momentum_of(const Pile& pile) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < pile.par.num_bodies; ++i) sum += pile.par.bodies[i].body.m * pile.at(i).v_W;
  return sum;
}

template <class I>
void rows_keep_momentum() {
  for (const Real h : {2e-4, 1e-3, 5e-3})
    for (const Real k : {1e3, 1e4, 1e6})
      for (const Real zeta : {0.0, 0.3})
        for (const Real mass_ratio : {1.0, 0.4, 2.5}) {
          const auto pile = std::make_unique<Pile<FewBodies<I>>>();
          pile->par.h = h;
          add_row(k, zeta, mass_ratio, *pile);
          const Vec3 before = momentum_of(*pile);
          ASSERT_TRUE(pile->run(0.3));
          EXPECT_LT(pile->at(0).v_W.x(), 0.9) << "the first ball met nothing";
          EXPECT_LT((momentum_of(*pile) - before).norm(), 1e-12 * before.norm())
              << I::name << ", h " << h << ", k " << k << ", zeta " << zeta << ", ratio " << mass_ratio;
        }
}
TEST(Momentum, IsKeptByBallsInARowImplicitEuler) { rows_keep_momentum<ImplicitEuler>(); }
TEST(Momentum, IsKeptByBallsInARowTrBdf2) { rows_keep_momentum<TrBdf2>(); }

/// Bricks and balls that are thrown at each other from all sides.
template <class I>
void draw_crash(unsigned seed, Pile<FewBodies<I>>& pile) {
  Random random(seed);
  pile.par.h = random.log_uniform(2e-4, 5e-3);
  set_law(pile.par, law_of(random.log_uniform(1e3, 1e6), random.uniform(0, 1), random.uniform(0, 0.8)));
  const int bodies = random.integer(2, 8);
  const bool on_floor = random.integer(0, 1) == 0;
  if (on_floor) pile.add_floor();
  for (int i = 0; i < bodies; ++i) {
    const Vec3 from = 0.05 * random.direction() + Vec3(0, 0, on_floor ? 0.08 : 0);
    const Start start{.X_WB = {.p = from, .q = random.rotation()},
                      .V_WB = {.w = 5 * random.vector(), .v = -8 * from + 0.05 * random.vector()}};
    const Real m = brick_mass * random.log_uniform(0.2, 5);
    if (random.integer(0, 2) == 0) pile.add_ball(start, m, 0.01);
    else pile.add_brick(start, m);
  }
}

template <class I>
void crashes_are_balanced() {
  Real worst = 0, worst_kept = 0;
  int touched = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const auto pile = std::make_unique<Pile<FewBodies<I>>>();
    draw_crash(seed, *pile);
    const bool is_free = pile->par.gravity_W.isZero();
    const Vec3 before = momentum_of(*pile);
    Real scale = 0;
    for (std::size_t i = 0; i < pile->par.num_bodies; ++i)
      scale += pile->par.bodies[i].body.m * pile->at(i).v_W.norm();
    Off off;
    for (int n = 0; n < 150; ++n) {
      take(*pile, off);
      ASSERT_FALSE(any(pile->out.fault)) << seed;
    }
    worst = std::max({worst, off.momentum, off.listed});
    touched += off.given > 0 ? 1 : 0;
    EXPECT_LT(off.momentum, 1e-9) << I::name << ", seed " << seed;
    EXPECT_LT(off.listed, 1e-9) << I::name << ", seed " << seed;
    if (!is_free) continue;
    const Real lost = (momentum_of(*pile) - before).norm() / scale;
    worst_kept = std::max(worst_kept, lost);
    EXPECT_LT(lost, 1e-12) << I::name << ", seed " << seed;
  }
  EXPECT_GT(touched, 50);
  std::printf("%s: forces off by %.1e of the largest, momentum by %.1e\n", I::name, worst, worst_kept);
}
TEST(Momentum, OfCrashesIsThatOfTheirForcesImplicitEuler) { crashes_are_balanced<ImplicitEuler>(); }
TEST(Momentum, OfCrashesIsThatOfTheirForcesTrBdf2) { crashes_are_balanced<TrBdf2>(); }

/// A tool of spheres that falls on a plane, flat or tilted.
template <class I>
void tools_are_balanced() {
  Real worst = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const auto run = std::make_unique<Running<OneTool<I>>>();
    const Real half = random.log_uniform(0.005, 0.2), m = random.log_uniform(0.01, 10);
    run->par.h = random.log_uniform(2e-4, 1e-2);
    run->par.gravity_W = Vec3(0, 0, -earth_gravity);
    run->par.bodies[0].body = solid_box(m, Vec3::Constant(half));
    run->in.devices[0].engaged = false;
    add_plane(run->par);
    const Real mu = random.uniform(0, 0.8), damping = random.uniform(0, 1);
    set_law(run->par, law_of(random.log_uniform(1e3, 1e6), damping, mu, m));
    for (int k = 0; k < 8; ++k)
      add_sphere(run->par, 0, 0.9 * half * Vec3(k % 2 ? 1 : -1, k % 4 < 2 ? 1 : -1, k < 4 ? 1 : -1),
                 0.1 * half);
    const bool is_tilted = random.integer(0, 2) > 0;
    const Quat q_WB = is_tilted ? random.rotation() : Quat(1, 0, 0, 0);
    const Vec3 w_WB = is_tilted ? random.vector() : Vec3(Vec3::Zero());
    const Real v_z = -random.log_uniform(0.1, 20), v_y = random.normal();
    place(run->x, 0,
          {.X_WB = {.p = Vec3(0, 0, 2 * half + 0.01), .q = q_WB},
           .V_WB = {.w = w_WB, .v = Vec3(random.normal(), v_y, v_z)}});
    Off off;
    for (int n = 0; n < 300; ++n) {
      take(*run, off);
      ASSERT_FALSE(any(run->out.fault)) << seed;
    }
    worst = std::max({worst, off.momentum, off.listed});
    EXPECT_GT(off.given, 0) << seed;
    EXPECT_LT(off.momentum, 1e-9) << I::name << ", seed " << seed;
    EXPECT_LT(off.listed, 1e-9) << I::name << ", seed " << seed;
  }
  std::printf("%s: tools' forces off by %.1e of the largest\n", I::name, worst);
}
TEST(Momentum, OfAToolOnAPlaneIsThatOfItsForcesImplicitEuler) { tools_are_balanced<ImplicitEuler>(); }
TEST(Momentum, OfAToolOnAPlaneIsThatOfItsForcesTrBdf2) { tools_are_balanced<TrBdf2>(); }

/// A tool that falls on a plane and turns about y alone: so its angular momentum is I w.
template <class I>
void turning_tools_are_balanced() {
  int num_turned = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const auto run = std::make_unique<Running<OneTool<I>>>();
    const Real half = random.log_uniform(0.005, 0.2), m = random.log_uniform(0.01, 10);
    run->par.h = random.log_uniform(2e-4, 5e-3);
    run->par.gravity_W = Vec3(0, 0, -earth_gravity);
    const RigidBodyParams& box = run->par.bodies[0].body = solid_box(m, half * Vec3(2, 1, 0.5));
    run->in.devices[0].engaged = false;
    add_plane(run->par);
    set_law(run->par, law_of(random.log_uniform(1e3, 1e6), random.uniform(0, 1), random.uniform(0, 0.8), m));
    for (int k = 0; k < 8; ++k)
      add_sphere(run->par, 0, 0.9 * half * Vec3(k % 2 ? 2 : -2, k % 4 < 2 ? 1 : -1, k < 4 ? 0.5 : -0.5),
                 0.05 * half);
    place(run->x, 0,
          {.X_WB = {.p = Vec3(0, 0, 2.5 * half), .q = exp_so3(Vec3(0, random.uniform(-3, 3), 0))},
           .V_WB = {.w = Vec3(0, random.normal(), 0),
                    .v = Vec3(random.normal(), 0, -random.log_uniform(0.1, 5))}});
    Real worst = 0;
    bool turned = false;
    for (int n = 0; n < 400; ++n) {
      const Real before = run->body().w_B.y();
      run->step();
      const Real L = box.I_B(1, 1) * (run->body().w_B.y() - before),
                 hT = run->par.h * run->out.bodies[0].contact.F_W.tau.y();
      turned = turned || std::abs(hT) > 0;
      const Real lever = run->par.h * half * run->out.bodies[0].contact.F_W.f.norm();
      if (lever > 0) worst = std::max(worst, std::abs(L - hT) / lever);
      else EXPECT_LT(std::abs(L), 1e-14 * box.I_B(1, 1) * std::max(std::abs(before), Real(1))) << seed;
    }
    num_turned += turned ? 1 : 0;
    EXPECT_LT(worst, 1e-9) << I::name << ", seed " << seed;
  }
  EXPECT_GT(num_turned, 30);
}
TEST(Momentum, OfATurningToolIsThatOfItsTorquesImplicitEuler) { turning_tools_are_balanced<ImplicitEuler>(); }
TEST(Momentum, OfATurningToolIsThatOfItsTorquesTrBdf2) { turning_tools_are_balanced<TrBdf2>(); }

/// Tools on joints that are hit, fall or are thrown, and that no device holds.
template <class I>
void jointed_piles_are_balanced() {
  Real worst = 0;
  int tried = 0, touched = 0;
  for (const DrawnKind kind : drawn_kinds)
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const auto pile = std::make_unique<DrawnPile<I>>(kind, seed);
      if (pile->is_held()) continue;
      Off off;
      for (int n = 0; n < 120; ++n) take(*pile, off);
      ++tried;
      touched += off.given > 0 ? 1 : 0;
      worst = std::max({worst, off.momentum, off.listed});
      EXPECT_LT(off.momentum, 1e-9) << I::name << ", kind " << static_cast<int>(kind) << ", seed " << seed;
      EXPECT_LT(off.listed, 1e-9) << I::name << ", kind " << static_cast<int>(kind) << ", seed " << seed;
    }
  EXPECT_GT(tried, 100);
  EXPECT_GT(touched, 50);
  std::printf("%s: %d tools on joints, %d touch; forces off by %.1e of the largest\n", I::name, tried,
              touched, worst);
}
TEST(Momentum, OfToolsOnJointsIsThatOfTheirForcesImplicitEuler) {
  jointed_piles_are_balanced<ImplicitEuler>();
}
TEST(Momentum, OfToolsOnJointsIsThatOfTheirForcesTrBdf2) { jointed_piles_are_balanced<TrBdf2>(); }

/// Angular impulses on the root of a tool in a stage of length h, N m s. missing: the part that its contacts,
/// its weight and the joints of its children do not explain. largest: the largest of these, and of all forces
/// of the scene at the lever of a corner.
struct RootTorque {
  Real missing = 0, largest = 0;
};
template <class Pile>
RootTorque root_torque(const Pile& pile, std::size_t root, Real h) {
  const auto& w = pile.w.contacts;
  const auto& joints = w.graph.joints;
  RootTorque torque;
  SpatialVector rest = SpatialVector::zero();
  const auto add = [&](const SpatialVector& F) {
    rest = rest + F;
    torque.largest = std::max(torque.largest, F.w.vec().norm() + F.v.vec().norm() * brick_half.norm());
  };
  const auto on_root = [&](const Wrench& F) {
    return SpatialVector{.w = Column(F.tau), .v = Column(F.f)} * h;
  };
  add(times(w.stages[root], w.x.V[root]));
  add(w.stages[root].b * -1);
  add(on_root(w.wrenches[root]) * -1);
  for (std::size_t i = 0; i < pile.par.num_bodies; ++i) {
    const Real f = (w.stages[i].b.v.vec() * (1 / h)).norm() + w.wrenches[i].f.norm();
    torque.largest = std::max(torque.largest, h * f * brick_half.norm());
    const JointEdge& edge = joints.edges[i];
    if (edge.kind == JointKind::free || edge.parent != root) continue;
    add(moved_wrench(on_root(pile.w.tree.nodes[i].F_C), edge.a_W - joints.p[root]));
    each_stop(i, joints, [&](const SpatialVector& J) noexcept {
      add(moved_wrench(J, joints.p[i] - joints.p[root]) * -1);
    });
  }
  torque.missing = rest.w.vec().norm();
  return torque;
}

/// Checks the equation of the solved stage for roots of tools. It is linear in their turns and torques, so it
/// holds to rounding in steps of one stage, whose length is known.
TEST(Momentum, OfRootsOfToolsIsThatOfTheirTorques) {
  Real worst = 0;
  int unbalanced = 0;
  for (const DrawnKind kind : drawn_kinds)
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const auto pile = std::make_unique<DrawnPile<ImplicitEuler>>(kind, seed);
      for (int n = 0; n < 120; ++n) {
        pile->go_on();
        if (has(pile->out.limited, Limited::substeps)) continue;
        unbalanced += pile->w.contacts.is_unbalanced ? 1 : 0;
        for (std::size_t i = 0; i < pile->par.num_bodies; ++i) {
          const auto& joints = pile->w.contacts.graph.joints;
          if (!joints.joined[i] || joints.edges[i].kind != JointKind::free) continue;
          const RootTorque torque = root_torque(*pile, i, pile->par.h);
          if (torque.largest > 0) worst = std::max(worst, torque.missing / torque.largest);
          EXPECT_LE(torque.missing, 1e-9 * torque.largest)
              << "kind " << static_cast<int>(kind) << ", seed " << seed << ", step " << n;
        }
      }
    }
  std::printf("%d steps end with a residual; torques of roots off by %.1e of the largest\n", unbalanced,
              worst);
  EXPECT_GT(unbalanced, 30);
}

}  // namespace
}  // namespace godobject::test_momentum
