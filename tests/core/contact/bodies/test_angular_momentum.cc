// Torques of contacts in outputs are means over the step: they equal the change of each free body's angular
// momentum R I w, in impacts too. Free bodies keep theirs.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_angular_momentum {
namespace {

template <class Run>
Vec3 angular_momentum_of(const Run& run, std::size_t i) {
  const RigidBodyState& x = run.x.bodies[i].x;
  return x.X_WB.q * Vec3(run.par.bodies[i].body.I_B * x.w_B);
}

/// Half extents of a box whose greatest moment of inertia is up to ten times the least.
Vec3 draw_half(Random& random) {
  const Real length = random.log_uniform(0.01, 0.1), z = random.log_uniform(0.24, 1),
             y = random.log_uniform(0.24, 1);
  return length * Vec3(1, y, z);
}

/// A box of eight spheres that falls on a plane, with tilt, spin, rebound and friction.
template <class I>
struct Dropped : Running<OneTool<I>> {
  Vec3 half;

  explicit Dropped(unsigned seed) {
    Random random(seed);
    auto& par = this->par;
    const Real m = random.log_uniform(0.01, 10);
    half = random.integer(0, 3) == 0 ? Vec3::Constant(random.log_uniform(0.01, 0.1)) : draw_half(random);
    par.h = random.log_uniform(2.5e-4, 5e-3);
    par.gravity_W = Vec3(0, 0, -earth_gravity);
    par.bodies[0].body = solid_box(m, half);
    this->in.devices[0].engaged = false;
    add_plane(par);
    const Real mu = random.uniform(0, 0.8), damping = random.uniform(0, 1);
    set_law(par, law_of(random.log_uniform(1e3, 1e5), damping, mu, m));
    const Real radius = 0.1 * half.minCoeff();
    for (int k = 0; k < 8; ++k)
      add_sphere(par, 0,
                 (half - Vec3::Constant(radius))
                     .cwiseProduct(Vec3(k % 2 ? 1 : -1, k % 4 < 2 ? 1 : -1, k < 4 ? 1 : -1)),
                 radius);
    const Quat q_WB = random.rotation();
    const Vec3 axis = random.direction(), w_WB = random.log_uniform(0.1, 30) * axis;
    const Real v_z = -random.log_uniform(0.3, 3), v_y = random.normal();
    place(this->x, 0,
          {.X_WB = {.p = Vec3(0, 0, half.norm() + 0.002), .q = q_WB},
           .V_WB = {.w = w_WB, .v = Vec3(random.normal(), v_y, v_z)}});
  }
};

/// Angular momentum in a run, N m s. missed: the change that the torques of outputs do not give.
struct Missed {
  Vec3 total = Vec3::Zero();
  Real in_step = 0, by_points = 0, largest = 0, given = 0;
};

template <class I>
Missed drop(unsigned seed) {
  const auto run = std::make_unique<Dropped<I>>(seed);
  Missed missed;
  for (int n = 0; n < 300; ++n) {
    const Vec3 before = angular_momentum_of(*run, 0);
    const Real h = run->par.h;
    const Vec3 predicted_W = run->body().X_WB.p + h * run->body().v_W;
    run->step();
    EXPECT_FALSE(any(run->out.fault)) << seed;
    const Vec3 now = angular_momentum_of(*run, 0), tau = run->out.bodies[0].contact.F_W.tau;
    const Vec3 step = now - before - h * tau;
    missed.total += step;
    missed.in_step = std::max(missed.in_step, step.norm());
    missed.largest = std::max({missed.largest, now.norm(), before.norm()});
    missed.given += h * tau.norm();
    if (I::order > 1) continue;
    Vec3 of_points = Vec3::Zero();
    for (std::size_t k = 0; k < run->w.means.contacts.size; ++k) {
      const ContactForce& one = run->w.means.contacts.list[k];
      of_points += (one.p_W - predicted_W).cross(one.F_W);
    }
    missed.by_points = std::max(missed.by_points, h * (of_points - tau).norm());
  }
  return missed;
}

template <class I>
void drops_are_balanced() {
  Real total = 0, in_step = 0, by_points = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const Missed missed = drop<I>(seed);
    EXPECT_GT(missed.given, 0.1 * missed.largest) << seed;
    EXPECT_LT(missed.total.norm(), 1e-9 * missed.largest) << I::name << ", seed " << seed;
    EXPECT_LT(missed.in_step, 1e-9 * missed.largest) << I::name << ", seed " << seed;
    EXPECT_LT(missed.by_points, 1e-9 * missed.largest) << I::name << ", seed " << seed;
    total = std::max(total, missed.total.norm() / missed.largest);
    in_step = std::max(in_step, missed.in_step / missed.largest);
    by_points = std::max(by_points, missed.by_points / missed.largest);
  }
  std::printf("%s: torques miss %.1e of the angular momentum in a run, %.1e in a step; points by %.1e\n",
              I::name, total, in_step, by_points);
}
TEST(AngularMomentum, OfADroppedBoxIsThatOfItsTorquesImplicitEuler) { drops_are_balanced<ImplicitEuler>(); }
TEST(AngularMomentum, OfADroppedBoxIsThatOfItsTorquesTrBdf2) { drops_are_balanced<TrBdf2>(); }

/// Bricks and balls thrown at each other: each has the change of its angular momentum by its torque.
template <class I>
void crashes_are_balanced() {
  Real worst = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const auto pile = std::make_unique<Pile<FewBodies<I>>>();
    pile->par.h = random.log_uniform(2.5e-4, 5e-3);
    set_law(pile->par, law_of(random.log_uniform(1e3, 1e5), random.uniform(0, 1), random.uniform(0, 0.8)));
    const int bodies = random.integer(2, 8);
    for (int i = 0; i < bodies; ++i) {
      const Vec3 from = 0.05 * random.direction();
      const Start start{.X_WB = {.p = from, .q = random.rotation()},
                        .V_WB = {.w = 5 * random.vector(), .v = -8 * from + 0.05 * random.vector()}};
      const Real m = brick_mass * random.log_uniform(0.2, 5);
      if (random.integer(0, 2) == 0) pile->add_ball(start, m, 0.01);
      else pile->add_brick(start, m);
    }
    std::array<Vec3, 8> before;
    Real largest = 0, missed = 0;
    for (int n = 0; n < 150; ++n) {
      for (std::size_t i = 0; i < pile->par.num_bodies; ++i) before[i] = angular_momentum_of(*pile, i);
      pile->step();
      ASSERT_FALSE(any(pile->out.fault)) << seed;
      for (std::size_t i = 0; i < pile->par.num_bodies; ++i) {
        const Vec3 now = angular_momentum_of(*pile, i);
        largest = std::max(largest, now.norm());
        missed =
            std::max(missed, (now - before[i] - pile->par.h * pile->out.bodies[i].contact.F_W.tau).norm());
      }
    }
    worst = std::max(worst, missed / largest);
    EXPECT_LT(missed, 1e-9 * largest) << I::name << ", seed " << seed;
  }
  std::printf("%s: torques in crashes miss %.1e of the largest angular momentum\n", I::name, worst);
}
TEST(AngularMomentum, OfCrashesIsThatOfTheirTorquesImplicitEuler) { crashes_are_balanced<ImplicitEuler>(); }
TEST(AngularMomentum, OfCrashesIsThatOfTheirTorquesTrBdf2) { crashes_are_balanced<TrBdf2>(); }

/// Tops in free flight, at turns of up to 0.4 rad in a step, keep their angular momentum and gain no energy.
template <class I>
void tops_are_free() {
  Real lost = 0, rise = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const auto run = std::make_unique<Running<OneTool<I>>>();
    run->par.h = 1e-3;
    run->in.devices[0].engaged = false;
    run->par.bodies[0].body = solid_box(0.2, draw_half(random));
    place(run->x, 0,
          {.X_WB = {.p = Vec3::Zero(), .q = random.rotation()},
           .V_WB = {.w = random.log_uniform(1, 400) * random.direction(), .v = Vec3::Zero()}});
    const Vec3 L = angular_momentum_of(*run, 0);
    const Real energy = run->kinetic();
    for (int n = 0; n < 2000; ++n) {
      run->step();
      ASSERT_FALSE(any(run->out.fault)) << seed;
      lost = std::max(lost, (angular_momentum_of(*run, 0) - L).norm() / L.norm());
      rise = std::max(rise, run->kinetic() / energy - 1);
    }
  }
  std::printf("%s: tops lose %.1e of their angular momentum, gain %.1e of their energy\n", I::name, lost,
              rise);
  EXPECT_LT(lost, 1e-9);
  EXPECT_LT(rise, I::order > 1 ? 2e-4 : 1e-12);
}
TEST(AngularMomentum, OfTopsIsConstantImplicitEuler) { tops_are_free<ImplicitEuler>(); }
TEST(AngularMomentum, OfTopsIsConstantTrBdf2) { tops_are_free<TrBdf2>(); }

}  // namespace
}  // namespace godobject::test_angular_momentum
