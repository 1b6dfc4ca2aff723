// Energy balance (38) with contacts: no false alarm for any falling body, and an alarm for a broken solver.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/energy_balance.h"
#include "tests/core/broken.h"
#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_energy_of_contacts {
namespace {

/// Throws a box of eight spheres along a floor. Returns true if a gain is reported.
template <class I>
bool gains(unsigned seed, bool has_friction) {
  using S = OneTool<I>;
  Random random(seed);
  const auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  run->in.devices[0].engaged = false;
  par.h = random.log_uniform(2e-4, 2e-3);
  par.gravity_W = Vec3(0, 0, -earth_gravity);
  const Real m = random.log_uniform(0.01, 1);
  par.bodies[0].body = solid_box(m, Vec3(0.02, 0.02, 0.01));
  for (int i = 0; i < 8; ++i)
    add_sphere(par, 0, Vec3(i & 4 ? 0.018 : -0.018, i & 2 ? 0.018 : -0.018, i & 1 ? 0.008 : -0.008), 0.002);
  add_plane(par);
  set_law(par, law_of(random.log_uniform(1e3, 1e8), 0.7, has_friction ? random.uniform(0, 1) : 0, m));
  const Quat q = has_friction ? random.rotation() : Quat(Quat::Identity());
  place<S>(run->x, 0,
           {.X_WB = {.p = Vec3(0, 0, 0.03), .q = q},
            .V_WB = {.w = (has_friction ? random.log_uniform(0.1, 50) : 0) * random.direction(),
                     .v = Vec3(random.uniform(0.2, 2), 0, -random.uniform(0, 2))}});
  EnergyBalance<S> balance;
  balance.start(par, run->x);
  bool reported = false;
  for (Real t = 0; t < 2; t += par.h) {
    run->step();
    balance.observe(par, run->x, run->w, run->out);
    reported = reported || balance.gains();
  }
  return reported;
}

template <class I>
class EnergyOfContacts : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(EnergyOfContacts, BothIntegrators);

#ifdef NDEBUG
constexpr unsigned num_throws = 200;
#else
constexpr unsigned num_throws = 5;  // builds with assertions and sanitizers take a hundred times as long
#endif

TYPED_TEST(EnergyOfContacts, NoThrownBoxIsReportedToGain) {
  for (unsigned seed = 0; seed < num_throws; ++seed) EXPECT_FALSE(gains<TypeParam>(seed, true)) << seed;
}

// 0.2 % in each step
TYPED_TEST(EnergyOfContacts, ABrokenSolverIsFoundInABoxThatSlides) {
  for (unsigned seed = 0; seed < num_throws / 5; ++seed) {
    EXPECT_FALSE(gains<TypeParam>(seed, false)) << seed;
    EXPECT_TRUE((gains<Broken<TypeParam, 2000>>(seed, false))) << seed;
  }
}

/// Bricks that fall on each other.
TYPED_TEST(EnergyOfContacts, NoHeapIsReportedToGain) {
  using S = FewBodies<TypeParam>;
  for (unsigned seed = 0; seed < num_throws / 5; ++seed) {
    Random random(seed);
    const auto pile = std::make_unique<Pile<S>>();
    pile->par.h = random.log_uniform(2.5e-4, 4e-3);
    set_law(pile->par,
            law_of(random.log_uniform(1e3, 1e7), 0.7 * random.integer(0, 2), random.uniform(0, 1)));
    pile->add_floor();
    for (int i = 0; i < 4; ++i)
      pile->add_brick(
          {.X_WB = {.p = Vec3(0, 0, 0.02 + 0.03 * i) + 0.003 * random.vector(), .q = random.rotation()},
           .V_WB = {.w = 10 * random.vector(), .v = 0.3 * random.vector()}});
    const auto balance = std::make_unique<EnergyBalance<S>>();
    balance->start(pile->par, pile->x);
    bool reported = false;
    for (Real t = 0; t < 1; t += pile->par.h) {
      pile->step();
      balance->observe(pile->par, pile->x, pile->w, pile->out);
      reported = reported || balance->gains();
    }
    EXPECT_FALSE(reported) << seed << ": " << balance->watch().gained() << " of "
                           << balance->watch().at_work() << " J";
  }
}

}  // namespace
}  // namespace godobject::test_energy_of_contacts
