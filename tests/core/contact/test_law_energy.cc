// Energy of the contact law in a stage: spring, damper and friction never gain any (docs/theory/contact.md).
#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/law.h"
#include "tests/core/one_body.h"

namespace godobject::test_law_energy {
namespace {

struct Pairing {
  ContactLaw law;
  Real h, m;
};

Pairing drawn(Random& random) {
  ContactLaw law{.k = random.log_uniform(1, 1e9),
                 .c = random.uniform(0, 1) < 0.2 ? 0 : random.log_uniform(1e-3, 1e5),
                 .mu = random.uniform(0, 2),
                 .k_t = random.uniform(0, 1) < 0.2 ? 0 : random.log_uniform(1, 1e9),
                 .c_t = random.log_uniform(1e-3, 1e5)};
  if (random.integer(0, 1) == 0) law.ratio = random.log_uniform(1e-3, 1e3);
  if (random.integer(0, 1) == 0) law.ratio_t = random.log_uniform(1e-3, 1e3);
  return {.law = law, .h = random.log_uniform(1e-6, 1e-1), .m = random.log_uniform(1e-6, 1e2)};
}

struct Bodies {
  static constexpr bool between_bodies = true;
};

StageLawOf<Real> stage_law_of(const Pairing& pairing) {
  return stage_law<Bodies>(pairing.law, pairing.m, pairing.m, pairing.h, pairing.h, true);
}

Real squared(Real a) { return a * a; }

/// Work of the normal force on the bodies plus the change of its spring's energy, at any velocity.
TEST(LawEnergy, OfTheNormalForceFallsAtEveryVelocity) {
  Random random(1);
  int with_force = 0;
  for (int i = 0; i < 200000; ++i) {
    const Pairing pairing = drawn(random);
    const StageLawOf<Real> law = stage_law_of(pairing);
    const Real d_0 = random.log_uniform(1e-9, 1e-2),
               e = random.uniform(0, 1) < 0.5 ? 0 : random.uniform(0, d_0),
               v_n = random.uniform(-1, 1) * random.log_uniform(1e-9, 10);
    const NormalForceOf<Real> normal = normal_force(law, d_0, e, v_n, pairing.h);
    const Real F_n = std::max(normal.F_0 - normal.eta_n * v_n, Real(0)), d = d_0 - pairing.h * v_n;
    const Real before = squared(d_0 - e), after = squared(std::max(d - e, Real(0)));
    const Real change = pairing.law.k / 2 * (after - before), work = pairing.h * v_n * F_n;
    with_force += F_n > 0;
    EXPECT_LE(work + change, 1e-12 * (std::abs(work) + pairing.law.k / 2 * (before + after)))
        << "k " << pairing.law.k << " c " << pairing.law.c << " h " << pairing.h << " d_0 " << d_0 << " e "
        << e << " v_n " << v_n;
  }
  EXPECT_GT(with_force, 50000);
}

/// Sums work and spring energy of friction, sticking and slipping, at any normal force.
TEST(LawEnergy, OfFrictionFallsAtEveryVelocity) {
  Random random(2);
  int sticking = 0, slipping = 0;
  for (int i = 0; i < 200000; ++i) {
    const Pairing pairing = drawn(random);
    const StageLawOf<Real> law = stage_law_of(pairing);
    const Real F_n = random.log_uniform(1e-6, 1e4), h = pairing.h;
    Vec3 v_t = random.log_uniform(1e-9, 10) * random.direction(), xi_0 = random.direction();
    v_t.z() = xi_0.z() = 0;
    xi_0 *= pairing.law.k_t > 0 ? random.log_uniform(1e-9, 1) * pairing.law.mu * F_n / pairing.law.k_t : 0;
    const Vec3 s = v_t + law.v_per_xi * xi_0;
    const Real eta_t = friction(friction_of(law), s.norm(), F_n);
    (eta_t < law.max_eta_t ? slipping : sticking)++;
    const Vec3 F_t = -eta_t * s;
    const Vec3 xi = law.kept * xi_0 - law.given * F_t;
    const Real work = h * v_t.dot(F_t), before = xi_0.squaredNorm(), after = xi.squaredNorm();
    EXPECT_LE(work + pairing.law.k_t / 2 * (after - before),
              1e-12 * (std::abs(work) + pairing.law.k_t / 2 * (before + after)))
        << "k_t " << pairing.law.k_t << " c_t " << pairing.law.c_t << " h " << h << " F_n " << F_n;
  }
  EXPECT_GT(sticking, 20000);
  EXPECT_GT(slipping, 20000);
}

}  // namespace
}  // namespace godobject::test_law_energy
