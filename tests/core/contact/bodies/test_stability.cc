// Bodies in contact over the ranges of stiffness, damping and step of scenes: finite, and no energy except
// that of the hand and of gravity.
#include <gtest/gtest.h>

#include <cstdio>
#include <iostream>

#include "tests/core/contact/usual_scenes.h"
#include "tests/support/share.h"

namespace godobject::test_touching_stability {
namespace {

template <class I>
using Three = Pile<FewBodies<I>>;

struct SweepCase {
  Real k, zeta, h, mu;
};
std::ostream& operator<<(std::ostream& os, const SweepCase& c) {
  return os << "k " << c.k << " N/m, " << c.zeta << " times critical, h " << c.h << " s, mu " << c.mu;
}

enum class Hand { none, coupled, imposed };

/// The limit of the coupling: after a step the body is where its device is.
SpringParams imposed(const RigidBodyParams& body, Real h) {
  const Real k = 1e9 / (h * h);
  return {.k = body.m * k, .g = 0, .k_r = principal_moments(body.I_B).z() * k, .g_r = 0};
}

/// Two bricks crosswise above a plane, to fall on it and on each other, and one beside them for the hand.
template <class I>
std::unique_ptr<Three<I>> crosswise(const SweepCase& c, Hand hand) {
  auto pile = std::make_unique<Three<I>>();
  pile->par.h = c.h;
  pile->add_floor();
  set_law(pile->par, law_of(c.k, c.zeta, c.mu));
  pile->add_brick({.X_WB = at(Vec3(0, 0, 0.0115), Vec3(0.1, 0.2, 0)), .V_WB = {}});
  pile->add_brick({.X_WB = at(Vec3(0.002, 0.001, 0.032), Vec3(0, 0.1, 1.4)),
                   .V_WB = {.w = Vec3::Zero(), .v = Vec3(0, 0, -0.3)}});
  const Pose beside = at(Vec3(-0.06, 0.002, 0.006));
  const std::size_t driven = pile->add_brick({.X_WB = beside, .V_WB = {}});
  const RigidBodyParams& body = pile->par.bodies[driven].body;
  if (hand != Hand::none)
    pile->hold_at(driven, beside, hand == Hand::imposed ? imposed(body, c.h) : spring(body, 500, 0.05));
  return pile;
}

/// The device of the third brick waits, goes through the others at up to 0.6 m/s, and comes back.
template <class I>
void shove(Three<I>& pile) {
  const Real t = static_cast<Real>(pile.x.tick + 1) * pile.par.h - 0.05;
  pile.lead_to(2, Vec3(-0.06 + 0.06 * (1 - std::cos(10 * std::max(t, Real(0)))), 0.002, 0.006));
}

/// Returns the gain without the energy of contact springs, which is zero at first and never negative.
template <class I>
Real gain(const SweepCase& c, Hand hand, Real seconds) {
  const auto pile = crosswise<I>(c, hand);
  const Real first = energy(pile->par, pile->x);
  Real work = 0, most = 0;
  for (int n = 0; n < seconds / c.h; ++n) {
    const Vec3 target = pile->in.devices[2].target.X_WD.p;
    if (hand != Hand::none) shove(*pile);
    pile->step();
    if (any(pile->out.fault)) return std::numeric_limits<Real>::infinity();
    if (hand != Hand::none)
      work += coupling_at(pile->par, pile->x, 2).F_WB.f.dot(pile->in.devices[2].target.X_WD.p - target);
    most = std::max(most, energy(pile->par, pile->x) - first - work);
    if (!(most < 1e3)) return std::numeric_limits<Real>::infinity();
  }
  return most;
}

#ifdef NDEBUG
constexpr std::array steps{1e-4, 3e-4, 1e-3, 2e-3, 5e-3};
#else
constexpr std::array steps{1e-3, 5e-3};  // builds with assertions and sanitizers take a hundred times as long
#endif

template <class I>
class TouchingStability : public ::testing::Test {
 protected:
  /// Over all stiffnesses, dampings and steps.
  void sweep(Hand hand, const char* name) {
    test::Share share;
    int cases = 0;
    Real worst = 0;
    for (const Real mu : {0.0, 0.5})
      for (int decade = 2; decade <= 9; ++decade)
        for (const Real zeta : {0.0, 0.1, 1.0, 10.0, 100.0})
          for (const Real h : steps) {
            if (!share.takes()) continue;
            const SweepCase c{.k = std::pow(10, decade), .zeta = zeta, .h = h, .mu = mu};
            const Real gained = gain<I>(c, hand, std::min(Real(0.6), 1500 * h));
            EXPECT_LT(gained, 1e-9) << I::name << ", " << name << ": " << c;
            worst = std::max(worst, gained);
            ++cases;
          }
    std::printf("%s, %s: %d cases, energy gained at most %.1e J\n", I::name, name, cases, worst);
  }
};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(TouchingStability, BothIntegrators);

TYPED_TEST(TouchingStability, FallingBricksGainNoEnergy) { this->sweep(Hand::none, "falling"); }
TYPED_TEST(TouchingStability, ShovedBricksGainNoMoreThanTheWorkOfTheHand) {
  this->sweep(Hand::coupled, "shoved");
}

/// The force at the end of a step does the work of the step where it is the only stage.
using ImposedStability = TouchingStability<ImplicitEuler>;
TEST_F(ImposedStability, BricksGainNoMoreThanTheWorkOfTheHand) { sweep(Hand::imposed, "imposed"); }

}  // namespace
}  // namespace godobject::test_touching_stability
