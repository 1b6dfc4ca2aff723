// Contacts over the ranges of stiffness, damping and step of scenes: finite, and no energy except the hand's.
#include <gtest/gtest.h>

#include <cstdio>
#include <iostream>

#include "tests/core/contact/usual_scenes.h"
#include "tests/support/share.h"

namespace godobject::test_contact_stability {
namespace {

/// Treatment of the body.
enum class Deed { dropped, thrown, pressed, dragged };

struct SweepCase {
  Real k, zeta, h, mu;
  Deed deed;
};
std::ostream& operator<<(std::ostream& os, const SweepCase& c) {
  return os << "k " << c.k << " N/m, " << c.zeta << " times critical, h " << c.h << " s, mu " << c.mu
            << ", deed " << static_cast<int>(c.deed);
}

constexpr Real m = 0.1;

/// A rod of five spheres, askew above a plane.
template <class I>
using Rod = Running<OneTool<I>>;

template <class I>
Rod<I> rod(const SweepCase& c) {
  Rod<I> run;
  auto& par = run.par;
  par.h = c.h;
  par.gravity_W = Vec3(0, 0, -9.81);
  par.bodies[0].body = rigid_body(m, Vec3(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal());
  par.bodies[0].device.rise = 0;
  for (int i = 0; i < 5; ++i) add_sphere(par, 0, Vec3(0, 0, -0.08 + 0.04 * i), 0.02);
  add_plane(par);
  const Real damping = c.zeta * 2 * std::sqrt(c.k * m);
  set_law(par, {.k = c.k, .c = damping, .mu = c.mu, .k_t = c.k, .c_t = damping});
  const Vec3 axis(0.6, 0.8, 0);
  Start start{.X_WB = {.p = Vec3(0, 0, 0.08), .q = exp_so3(Vec3(1.2 * axis))}, .V_WB = {}};
  if (c.deed == Deed::thrown) start.V_WB = {.w = Vec3(3, 5, 20), .v = Vec3(1, 0, -1)};
  place(run.x, 0, start);
  run.device().engaged = c.deed == Deed::pressed || c.deed == Deed::dragged;
  if (!run.device().engaged) return run;
  par.bodies[0].coupling = spring(par.bodies[0].body, 1e3, 1);
  hold_at(run, {.p = Vec3(0, 0, -0.01), .q = exp_so3(Vec3(1.5 * axis))});
  return run;
}

/// The device's target to and fro over the plane, once it has rested a while.
template <class I>
void drag(Rod<I>& run) {
  const Real u = std::max(Real(0), static_cast<Real>(run.x.tick + 1) * run.par.h - 0.3);
  run.device().target.X_WD.p = Vec3(0.05 * (1 - std::cos(10 * u)), 0.03 * (1 - std::cos(14 * u)), -0.01);
  run.device().target.V_WD.v = Vec3(0.5 * std::sin(10 * u), 0.42 * std::sin(14 * u), 0);
}

/// Returns the gain of the energy of body, coupling and gravity over the initial energy and the work of the
/// hand, J. The energy of contact springs is left out. A stiff one stores joules by the error of a body's
/// rotation in a step, and does not return them.
template <class I>
Real gain(const SweepCase& c, Real seconds) {
  auto run = rod<I>(c);
  const Real first = energy(run.par, run.x);
  Real work = 0, most = 0;
  for (int n = 0; n < seconds / c.h; ++n) {
    const Vec3 target = run.device().target.X_WD.p;
    if (c.deed == Deed::dragged) drag(run);
    run.step();
    if (any(run.out.fault) || !is_finite(run.body())) return std::numeric_limits<Real>::infinity();
    work += coupling_at(run.par, run.x, 0).F_WB.f.dot(run.device().target.X_WD.p - target);
    most = std::max(most, energy(run.par, run.x) - first - work);
  }
  return most;
}

template <class I>
class ContactStability : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ContactStability, BothIntegrators);

#ifdef NDEBUG
constexpr std::array steps{1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3};
#else
constexpr std::array steps{1e-3, 5e-3};  // builds with assertions and sanitizers take a hundred times as long
#endif

TYPED_TEST(ContactStability, NoStiffnessDampingOrStepGainsEnergy) {
  test::Share share;
  int cases = 0;
  Real worst = 0;
  for (const Deed deed : {Deed::dropped, Deed::thrown, Deed::pressed, Deed::dragged})
    for (const Real mu : {0.0, 0.5})
      for (int decade = 2; decade <= 9; ++decade)
        for (const Real zeta : {0.0, 0.1, 1.0, 10.0, 100.0})
          for (const Real h : steps) {
            if (!share.takes()) continue;
            const SweepCase c{.k = std::pow(10, decade), .zeta = zeta, .h = h, .mu = mu, .deed = deed};
            const Real gained = gain<TypeParam>(c, std::min(Real(0.6), 2000 * h));
            EXPECT_LT(gained, 1e-9) << TypeParam::name << ": " << c;
            worst = std::max(worst, gained);
            ++cases;
          }
  std::printf("%s: %d cases, energy gained at most %.1e J\n", TypeParam::name, cases, worst);
}

}  // namespace
}  // namespace godobject::test_contact_stability
