// Jointed bodies in contact, over the ranges of stiffness, damping and step of scenes: no energy except that
// of the hand and of gravity.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject::test_touching_joint_stability {
namespace {

/// Returns two pendulums of two links each, hinged to the world a brick's width apart. They fall against each
/// other and a free brick between them.
template <class I>
std::unique_ptr<JointedPileOf<I>> pendulums() {
  auto pile = std::make_unique<JointedPileOf<I>>();
  pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
  const Vec3 end(brick_half.x() + 0.001, 0, 0);
  const Mat3 down = exp_so3(Vec3(0, pi / 2, 0)).toRotationMatrix();  // x of the links
  for (const Real side : {-1.0, 1.0}) {
    const JointFrame pivot{.p = Vec3(0.02 * side, 0, 0.1), .R = down * frame(Vec3::Zero(), y_axis).R};
    const std::size_t upper = pile->add_brick({});
    pile->join(upper, JointKind::hinge, world, pivot, frame(-end, y_axis), {.q = Vec3(-1.2 * side, 0, 0)});
    const std::size_t lower = pile->add_brick({});
    pile->join(lower, JointKind::hinge, upper, frame(end, y_axis), frame(-end, y_axis));
  }
  pile->add_brick({.X_WB = at(Vec3(0, 0.001, 0.05)), .V_WB = {.w = Vec3::Zero(), .v = Vec3(0, 0, 0.5)}});
  return pile;
}

/// Three bricks, one of them heavy, fall on a chain that falls on a floor.
template <class I>
std::unique_ptr<JointedPileOf<I>> falling_chain(JointKind kind) {
  auto pile = std::make_unique<JointedPileOf<I>>();
  pile->add_floor();
  pile->add_chain(4, {.X_WB = at(Vec3(-0.05, 0, 0.03), Vec3(0.1, 0.2, 0)), .V_WB = {}}, kind);
  for (int i = 0; i < 3; ++i)
    pile->add_brick({.X_WB = at(Vec3(-0.05 + 0.04 * i, 0.002, 0.06 + 0.02 * i), Vec3(0.4 * i, 0.3, 0.2 * i)),
                     .V_WB = {.w = Vec3(3, -5, 2), .v = Vec3(0, 0, -0.5)}},
                    (i == 2 ? 20 : 1) * brick_mass);
  return pile;
}

/// Returns the initial energy of contacts (35), J, which TR-BDF2 may gain. Implicit Euler has lost more than
/// that by then.
template <class I>
Real given(const ContactReport& contacts) {
  return I::order > 1 ? std::max(contacts.found, Real(0)) : 0;
}

/// Returns the largest gain in 0.6 s, or 1500 steps. The energy of contact springs is left out: zero at
/// first, never negative.
template <class I>
Real gain(JointedPileOf<I>& pile, const ContactLaw& law, Real h) {
  pile.par.h = h;
  set_law(pile.par, law);
  const Real first = energy(pile.par, pile.x);
  Real gained = 0, work = 0;
  bool touches = false;
  for (int n = 0; n < std::min(0.6 / pile.par.h, 1500.0); ++n) {
    pile.step();
    if (any(pile.out.fault)) return std::numeric_limits<Real>::infinity();
    work += given<I>(pile.out.contacts);
    gained = std::max(gained, energy(pile.par, pile.x) - first - work);
    // stiff contacts may be open again where the step ends
    for (std::size_t i = 0; i < num_bodies(pile.par); ++i)
      touches = touches || !pile.out.bodies[i].contact.F_W.f.isZero(0);
  }
  EXPECT_TRUE(touches);
  return gained;
}

#ifdef NDEBUG
constexpr std::array stiffnesses{1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr std::array steps{1e-4, 3e-4, 1e-3, 2e-3, 5e-3};
#else
constexpr std::array stiffnesses{1e4};  // builds with assertions and sanitizers take a hundred times as long
constexpr std::array steps{1e-3};
#endif

/// No case gains energy: gained(law, h) of every stiffness, damping, friction and step.
template <class F>
void expect_no_gain(const char* name, F gained) {
  int cases = 0;
  Real worst = 0;
  for (const Real k : stiffnesses)
    for (const Real zeta : {0.0, 0.1, 1.0, 10.0, 100.0})
      for (const Real mu : {0.0, 0.5})
        for (const Real h : steps) {
          const Real most = gained(law_of(k, zeta, mu), h);
          EXPECT_LT(most, 1e-9) << name << ": k " << k << " N/m, " << zeta << " times critical, mu " << mu
                                << ", " << h << " s";
          worst = std::max(worst, most);
          ++cases;
        }
  std::printf("%s: %d cases, energy gained at most %.1e J\n", name, cases, worst);
}

template <class I>
class TouchingJointStability : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(TouchingJointStability, BothIntegrators);

TYPED_TEST(TouchingJointStability, PendulumsGainNoEnergy) {
  expect_no_gain("pendulums",
                 [](const ContactLaw& law, Real h) { return gain(*pendulums<TypeParam>(), law, h); });
}

TYPED_TEST(TouchingJointStability, ChainsThatAreHitGainNoEnergy) {
  for (const auto& [kind, name] : {std::pair{JointKind::free, "free bricks"},
                                   {JointKind::fixed, "fixed joints"},
                                   {JointKind::hinge, "hinges"},
                                   {JointKind::ball, "ball joints"},
                                   {JointKind::slider, "sliders"}}) {
    // TR-BDF2 takes longer; its differences do not depend on the kind of joint
    if (TypeParam::order > 1 && (kind == JointKind::free || kind == JointKind::ball)) continue;
    expect_no_gain(name, [kind = kind](const ContactLaw& law, Real h) {
      return gain(*falling_chain<TypeParam>(kind), law, h);
    });
  }
}

/// Moves a gripper by its palm with a brick between its jaws. Returns the largest gain beyond the work of the
/// hand.
template <class I>
Real gain_of_gripper(const ContactLaw& law, Real h) {
  using Gripper = GripperOf<I>;
  const auto grip = std::make_unique<Gripper>();
  grip->par.h = h;
  set_law(grip->par, law);
  const Real first = energy(grip->par, grip->x);
  Real work = 0, gained = 0;
  for (int n = 1; n <= std::min(0.6 / h, 2000.0); ++n) {
    const Vec3 before = grip->in.devices[Gripper::palm].target.X_WD.p;
    const Real t = n * h;
    const Vec3 after(0.03 * std::sin(20 * t), 0.01 * (1 - std::cos(35 * t)),
                     Gripper::height + 0.02 * (1 - std::cos(15 * t)));
    const Vec3 F_before = coupling_at(grip->par, grip->x, Gripper::palm).F_WB.f;
    grip->lead_to(Gripper::palm, after);
    grip->step();
    if (any(grip->out.fault)) return std::numeric_limits<Real>::infinity();
    const Vec3 F = coupling_at(grip->par, grip->x, Gripper::palm).F_WB.f;
    // by the force at the end, which is implicit Euler's, or by the mean
    const Real by_end = F.dot(after - before), by_mean = Real(0.5) * (F + F_before).dot(after - before);
    work += (I::order > 1 ? std::max(by_end, by_mean) : by_end) + given<I>(grip->out.contacts);
    gained = std::max(gained, energy(grip->par, grip->x) - first - work);
  }
  return gained;
}

TYPED_TEST(TouchingJointStability, AGripperGainsNoMoreThanTheWorkOfTheHand) {
  expect_no_gain("gripper", gain_of_gripper<TypeParam>);
}

}  // namespace
}  // namespace godobject::test_touching_joint_stability
