// Steps whose energy rises out of all measure (58) are not taken, whatever caused it; honest ones are,
// however abrupt.
#include <gtest/gtest.h>

#include <memory>

#include "tests/core/one_body.h"

namespace godobject::test_energy_rise {
namespace {

/// A solver that fails on demand: velocities come out too large by a factor.
template <class I>
struct Failing : I {
  static inline Real factor = 1;

  template <Scene S>
  static Limited advance(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    const Limited limited = I::advance(par, x, w);
    for (std::size_t g = 0; g < num_groups(par); ++g) {
      w.next[g].x.v_W *= factor;
      w.next[g].x.w_B *= factor;
    }
    return limited;
  }
};

template <class I>
class EnergyRise : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(EnergyRise, BothIntegrators);

/// A body swings on its coupling; one step fails, and the next goes on from the last good state.
TYPED_TEST(EnergyRise, OutOfMeasureIsAFaultOfItsStepAlone) {
  using Solver = Failing<TypeParam>;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Running<OneBody<Solver>> run;
    run.constants().body = rigid_body(0.1, Mat3(1e-4 * Mat3::Identity()));
    run.constants().coupling = {.k = 100, .g = 1, .k_r = 0.1, .g_r = 1e-3};
    run.constants().device.rise = 0;
    place(run.x, 0,
          {.X_WB = {.p = 0.05 * random.vector()}, .V_WB = {.w = random.vector(), .v = random.vector()}});
    engage_at(run.x, 0, {});
    run.device().engaged = run.device().valid = true;
    const auto alike = std::make_unique<Running<OneBody<Solver>>>(run);
    const int good = random.integer(1, 50);
    run.step(good);
    alike->step(good);
    const RigidBodyState before = run.body();
    Solver::factor = random.log_uniform(1e4, 1e150);
    run.step();
    Solver::factor = 1;
    EXPECT_EQ(run.out.fault, Fault::energy_gained);
    EXPECT_EQ(run.body().X_WB.p, before.X_WB.p);
    EXPECT_EQ(run.body().v_W, before.v_W);
    EXPECT_EQ(run.body().w_B, before.w_B);
    run.step();
    alike->step();
    EXPECT_EQ(run.out.fault, Fault::none);
    EXPECT_EQ(run.body().X_WB.p, alike->body().X_WB.p);
    EXPECT_EQ(run.body().v_W, alike->body().v_W);
  }
}

/// From rest: targets that jump, or move at once, with couplings of all kinds.
TYPED_TEST(EnergyRise, NothingThatATargetDoesIsOutOfMeasure) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    Random random(seed);
    Running<OneBody<TypeParam>> run;
    auto& par = run.par;
    par.h = random.log_uniform(1e-4, 1e-2);
    par.gravity_W = random.integer(0, 1) * 9.81 * random.direction();
    const Real m = random.log_uniform(1e-3, 10), I = m * random.log_uniform(1e-6, 1e-2);
    run.constants().body =
        rigid_body(m, random.inertia(I * Vec3(1, random.uniform(1, 3), random.uniform(2, 3))));
    const Real k = random.log_uniform(1, 1e8), k_r = random.log_uniform(1e-3, 1e5),
               zeta = random.uniform(0, 3);
    run.constants().coupling = {.k = random.integer(0, 1) * k,
                                .g = zeta * std::sqrt(m * k),
                                .k_r = random.integer(0, 1) * k_r,
                                .g_r = zeta * std::sqrt(I * k_r)};
    run.constants().device.rise = 0;
    place(run.x, 0, {});
    engage_at(run.x, 0, {});
    run.device().engaged = run.device().valid = true;
    for (int n = 0; n < 100; ++n) {
      if (n % 10 == 0)
        run.device().target = {
            .X_WD = {.p = random.log_uniform(1e-6, 1) * random.vector(), .q = random.rotation()},
            .V_WD = {.w = random.log_uniform(1e-3, 100) * random.vector(),
                     .v = random.log_uniform(1e-3, 10) * random.vector()}};
      run.step();
      ASSERT_EQ(run.out.fault, Fault::none) << "seed " << seed << ", step " << n;
    }
  }
}

/// Forces applied from rest.
TYPED_TEST(EnergyRise, NothingThatAForceDoesIsOutOfMeasure) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Random random(seed);
    Running<OneBody<TypeParam, AdmittanceDevice, None>> run;
    run.par.h = random.log_uniform(1e-4, 1e-2);
    const Real m = random.log_uniform(1e-3, 10), I = m * random.log_uniform(1e-6, 1e-2);
    run.constants().body =
        rigid_body(m, random.inertia(I * Vec3(1, random.uniform(1, 3), random.uniform(2, 3))));
    place(run.x, 0, {});
    run.device().engaged = run.device().valid = true;
    for (int n = 0; n < 50; ++n) {
      run.device().F_WB = {.tau = random.log_uniform(1e-6, 1) * random.vector(),
                           .f = random.log_uniform(1e-6, 1e3) * random.vector()};
      run.step();
      ASSERT_EQ(run.out.fault, Fault::none) << "seed " << seed << ", step " << n;
    }
  }
}

/// A body in flight, whose energy is all motion. A failed step need not be far out of measure to be rejected.
TYPED_TEST(EnergyRise, OfTwelveTimesOrMoreIsAFault) {
  using Solver = Failing<TypeParam>;
  for (unsigned seed = 0; seed < 50; ++seed) {
    Random random(seed);
    Running<OneBody<Solver>> run;
    run.constants().body = rigid_body(0.1, random.inertia(Vec3(1e-4, 2e-4, 2.5e-4)));
    place(run.x, 0, {.X_WB = {}, .V_WB = {.w = random.vector(), .v = random.vector()}});
    run.device().engaged = run.device().valid = false;
    run.step(random.integer(1, 50));
    EXPECT_EQ(run.out.fault, Fault::none);
    Solver::factor = std::sqrt(random.uniform(12, 90));
    run.step();
    Solver::factor = 1;
    EXPECT_EQ(run.out.fault, Fault::energy_gained);
  }
}

/// A body with a constant force.
template <class I>
struct Forced : OneBody<I, None, None> {
  static constexpr std::size_t max_bodies = 1;
  using Contacts = BodyContacts<1, 1, 1>;
  using Terms = TermList<ConstantForces<1>>;
};

/// From rest, far from the origin, where the potential of the force is zero.
TYPED_TEST(EnergyRise, NothingThatAConstantForceDoesIsOutOfMeasure) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Random random(seed);
    auto run = std::make_unique<Running<Forced<TypeParam>>>();
    run->par.h = random.log_uniform(1e-4, 1e-2);
    run->par.num_bodies = 1;
    const Real m = random.log_uniform(1e-3, 10), I = m * random.log_uniform(1e-6, 1e-2);
    run->constants().body = rigid_body(m, random.inertia(I * Vec3(1, 2, 2.5)));
    auto& forces = run->par.terms.template of<0>();
    forces.list[forces.size++] = {.at = {.on = 0, .p = random.integer(0, 1) * 0.1 * random.vector()},
                                  .F_W = random.log_uniform(1e-3, 100) * random.vector()};
    place(run->x, 0, {.X_WB = {.p = random.vector(), .q = random.rotation()}, .V_WB = {}});
    ASSERT_EQ(validate(run->par), Invalid::nothing);
    for (int n = 0; n < 20; ++n) {
      run->step();
      ASSERT_EQ(run->out.fault, Fault::none) << "seed " << seed << ", step " << n;
    }
  }
}

/// (38)  A step without finite energy counts as a gain; later steps are compared with the state before it.
TEST(EnergyRiseWatch, KeepsAFiniteReference) {
  constexpr Real inf = std::numeric_limits<Real>::infinity();
  for (const Real bad : {inf, std::numeric_limits<Real>::quiet_NaN(), -inf}) {
    GainWatch watch;
    watch.start(1);
    for (int n = 0; n < 100; ++n) watch.observe(1, 1, 0, 0, 1e-3);
    EXPECT_FALSE(watch.gains());
    watch.observe(bad, 1, 0, 0, 1e-3);
    EXPECT_TRUE(watch.gains());
    watch.observe(1, inf, 0, 0, 1e-3);
    EXPECT_TRUE(watch.gains());
    EXPECT_TRUE(std::isfinite(watch.gained()) && std::isfinite(watch.at_work()));
    for (int n = 0; n < 20; ++n) watch.observe(1, 1, 0, 0, 1e-3);
    EXPECT_FALSE(watch.gains());
    EXPECT_LT(watch.at_work(), 10);
    for (int n = 0; n < 20; ++n) watch.observe(2, 1, 0, 0, 1e-3);
    EXPECT_TRUE(watch.gains());
    EXPECT_NEAR(watch.gained(), 1, 1e-9);
  }
}

}  // namespace
}  // namespace godobject::test_energy_rise
