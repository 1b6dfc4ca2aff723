// Nets over the ranges of stiffness, mass, damping, anchors and step of scenes, in all ordeals. Finite,
// bounded, and no energy except that of the hand and of gravity.
#include <gtest/gtest.h>

#include "tests/core/net/random_net.h"
#include "tests/core/net/usual_scene.h"
#include "tests/support/share.h"

namespace godobject::test_net_stability {
namespace {

#ifdef NDEBUG
constexpr unsigned seeds = 125;  // of each ordeal and integrator: 2000 in all
#else
constexpr unsigned seeds = 4;  // builds with assertions and sanitizers take a hundred times as long
#endif
/// Least share of cases with contact forces, among those pressed on something; it is 87 to 92 %. Four cases
/// are too few for a statement.
constexpr double pressed_share = 0.85;
constexpr bool is_whole_sweep = seeds >= 100;

/// Outcome of a case.
struct Outcome {
  bool finite = true, gains = false, pressed = false;
  Real worst = 0;     // gain, of the energy at work
  Real farthest = 0;  // from the origin, as a share of the possible distance
};

/// Bound of the distance from the origin that a net on anchors may reach in a time t. It adds its start, the
/// hand's way, its initial speed and its fall. Springs swing their loads about twice as far to the other
/// side. For free nets, thrown by springs and jaws, only finiteness is required.
template <class I>
class Range {
 public:
  explicit Range(const RandomNet<I>& net) : start_(net.reach()), fall_(net.of.gravity / 2) {
    for (std::size_t n = 0; n < net.par.net.num_nodes; ++n)
      speed_ = std::max(speed_, net.x.net.nodes[n].v_W.norm());
  }
  Real at(const RandomNet<I>& net, Real t) {
    hand_ = std::max(hand_, net.in.devices[0].target.X_WD.p.norm());
    return 3 * (start_ + hand_ + speed_ * t + fall_ * t * t);
  }

 private:
  Real start_, fall_, speed_ = 0, hand_ = 0;
};

template <class I>
Outcome outlive(RandomNet<I>& net) {
  Outcome outcome;
  Range<I> range(net);
  for (int n = 0; n < net.of.steps(); ++n) {
    outcome.finite = net.step_and_watch() && std::isfinite(net.reach());
    if (!outcome.finite) return outcome;
    outcome.pressed = outcome.pressed || net.out.net.num_contacts > 0;
    outcome.farthest = std::max(outcome.farthest, net.reach() / range.at(net, (n + 1) * net.of.h));
    const GainWatch& watch = net.balance.watch();
    if (!watch.gains()) continue;
    outcome.gains = true;
    outcome.worst = std::max(outcome.worst, watch.gained() / std::max(watch.at_work(), gain_floor));
  }
  return outcome;
}

template <class I>
class NetStability : public ::testing::Test {
 protected:
  void outlive_all(Ordeal ordeal) {
    unsigned pressed = 0;
    Real farthest = 0;
    test::Share share;
    for (unsigned seed = 0; seed < seeds; ++seed) {
      if (!share.takes()) continue;
      auto net = std::make_unique<RandomNet<I>>(seed, static_cast<int>(ordeal));
      const Outcome outcome = outlive(*net);
      EXPECT_TRUE(outcome.finite) << "seed " << seed << ": " << net->of.text();
      EXPECT_FALSE(outcome.gains) << "seed " << seed << ", " << outcome.worst
                                  << " of the energy at work: " << net->of.text();
      if (outcome.pressed) ++pressed;
      if (!(net->of.anchors > 0)) continue;
      EXPECT_LT(outcome.farthest, 1) << "seed " << seed << ": " << net->of.text();
      farthest = std::max(farthest, outcome.farthest);
    }
    std::printf("%s, %s: %u of %u pressed, farthest %.2f of what may be\n", I::name,
                ordeal_names[static_cast<int>(ordeal)], pressed, seeds, farthest);
    const bool is_pressed = ordeal == Ordeal::pinched || ordeal == Ordeal::jaws || ordeal == Ordeal::hole;
    if (is_whole_sweep && share.is_all() && is_pressed) {
      EXPECT_GE(pressed, pressed_share * seeds);
    }
  }
};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(NetStability, BothIntegrators);

TYPED_TEST(NetStability, Held) { this->outlive_all(Ordeal::held); }
TYPED_TEST(NetStability, InFlight) { this->outlive_all(Ordeal::free); }
TYPED_TEST(NetStability, InsideOut) { this->outlive_all(Ordeal::inside_out); }
TYPED_TEST(NetStability, WithANodeFarAway) { this->outlive_all(Ordeal::far_node); }
TYPED_TEST(NetStability, SwayedByTheHand) { this->outlive_all(Ordeal::swayed); }
TYPED_TEST(NetStability, PinchedInTheWorld) { this->outlive_all(Ordeal::pinched); }
TYPED_TEST(NetStability, PinchedBetweenBodies) { this->outlive_all(Ordeal::jaws); }
TYPED_TEST(NetStability, ThroughAHole) { this->outlive_all(Ordeal::hole); }

/// (46)  Support of a net against gravity takes no energy that its springs might gain. Here, one turns slowly
/// on a soft coupling, with springs of 1e8 N/m, in steps of 5 ms.
TEST(NetGravity, AllowsSpringsNoGain) {
  for (const Real m : {1e-3, 1e-2, 1e-1}) {
    RandomNet<ImplicitEuler> net(11, static_cast<int>(Ordeal::far_node), [m](Drawn& of) {
      of.k = 1e8;
      of.m = m;
      of.h = 5e-3;
    });
    const Outcome outcome = outlive(net);
    EXPECT_TRUE(outcome.finite) << net.of.text();
    EXPECT_FALSE(outcome.gains) << outcome.worst << " of the energy at work: " << net.of.text();
  }
}

/// Damped nets, 2.3 s or more after the hand has come to rest. Springs and anchors are within reach of each
/// other, with half a second or less to converge.
template <class I>
bool comes_to_rest(Ordeal ordeal, unsigned seed) {
  constexpr Real settled = 2.5, at_rest = 1e-3;  // s, m/s
  auto net = std::make_unique<RandomNet<I>>(seed, static_cast<int>(ordeal), [ordeal](Drawn& of) {
    of.on_carrier = true;
    of.anchors = std::max(of.anchors, Real(0.1));
    of.k = std::max(of.k, 100 * of.m / of.anchors * 100);  // anchors at 100 rad/s or above
    of.zeta = std::max(of.zeta, Real(0.2));
    of.cap = 12;
    of.gravity = 0;
    if (ordeal == Ordeal::held || ordeal == Ordeal::swayed) return;
    // the coupling's damper is that of the carrier alone: nets weigh no more, and 30 rad/s are left with them
    of.carrier_m = std::max(of.carrier_m, 64 * of.m);
    of.coupling_k = std::max(of.coupling_k, 2 * 30 * 30 * of.carrier_m);
  });
  Real fastest = 0;
  for (int n = 0; n < static_cast<int>(settled / net->of.h); ++n)
    if (!net->step_and_watch()) fastest = std::numeric_limits<Real>::infinity();
  for (std::size_t n = 0; n < net->par.net.num_nodes; ++n)
    fastest = std::max(fastest, net->x.net.nodes[n].v_W.norm());
  if (!(fastest < at_rest))
    std::printf("%s, seed %u: %.2g m/s: %s\n", I::name, seed, fastest, net->of.text().c_str());
  return fastest < at_rest;
}
template <class I>
unsigned count_restless(Ordeal ordeal, unsigned cases) {
  unsigned restless = 0;
  test::Share share;
  for (unsigned seed = 0; seed < cases; ++seed)
    restless += !share.takes() || comes_to_rest<I>(ordeal, seed) ? 0 : 1;
  return restless;
}
constexpr unsigned swayed_cases = seeds / 5 + 4, other_cases = seeds / 10 + 2;

TEST(NetRest, DampedNetsRestWhenTheHandDoes) {
  for (const Ordeal ordeal : {Ordeal::held, Ordeal::swayed}) {
    EXPECT_EQ(count_restless<ImplicitEuler>(ordeal, swayed_cases), 0u);
    EXPECT_EQ(count_restless<TrBdf2>(ordeal, swayed_cases), 0u);
  }
}
TEST(NetRest, DampedNetsRestThatWerePulledOut) {
  EXPECT_EQ(count_restless<ImplicitEuler>(Ordeal::far_node, other_cases), 0u);
  EXPECT_EQ(count_restless<TrBdf2>(Ordeal::far_node, other_cases), 0u);
}
TEST(NetRest, DampedNetsRestPressed) {
  for (const Ordeal ordeal : {Ordeal::pinched, Ordeal::jaws, Ordeal::hole}) {
    EXPECT_EQ(count_restless<ImplicitEuler>(ordeal, other_cases), 0u);
    EXPECT_EQ(count_restless<TrBdf2>(ordeal, other_cases), 0u);
  }
}
TEST(NetRest, DampedNetsRestThatBeginInsideOut) {
  EXPECT_EQ(count_restless<ImplicitEuler>(Ordeal::inside_out, other_cases), 0u);
  EXPECT_EQ(count_restless<TrBdf2>(Ordeal::inside_out, other_cases), 0u);
}

}  // namespace
}  // namespace godobject::test_net_stability
