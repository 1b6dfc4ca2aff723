// Light nets of stiff springs whose iterations are stopped after one or two: p^T A p is below its rounding, and no velocity may come of it.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/net/random_net.h"
#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_one_iteration {
namespace {

/// The largest rise of E - W in a step, in parts of all the energy there was at first and that has been given since.
template <class I>
Real largest_rise() {
  Real most = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    auto net = std::make_unique<RandomNet<I>>(seed,
                                              static_cast<int>(seed % 3 == 0   ? Ordeal::free
                                                               : seed % 3 == 1 ? Ordeal::held
                                                                               : Ordeal::pinched),
                                              [seed](Drawn& of) {
                                                of.k = std::pow(10, 6 + 0.05 * (seed % 61));
                                                of.m = 1e-7;
                                                of.zeta = seed % 2;
                                                of.h = 2.5e-3;
                                                of.gravity = 9.81;
                                                of.cap = 1 + static_cast<int>(seed % 2);
                                              });
    Real before = net->balance.balance(), given = std::abs(net->balance.energy()) + 1e-6;
    for (int n = 0; n < 400; ++n) {
      EXPECT_TRUE(net->step_and_watch()) << "seed " << seed << ": " << net->of.text();
      const Real now = net->balance.balance();
      EXPECT_TRUE(std::isfinite(now)) << "seed " << seed << ": " << net->of.text();
      given = std::max(given, std::abs(net->balance.energy() - now));
      most = std::max(most, (now - before) / given);
      before = now;
    }
  }
  std::printf("%s: rises by %.1e of the energy there is\n", I::name, most);
  return most;
}
TEST(NetOneIteration, CommitsNoEnergyOutOfMeasureWithImplicitEuler) {
  EXPECT_LT(largest_rise<ImplicitEuler>(), 1);
}
TEST(NetOneIteration, CommitsNoEnergyOutOfMeasureWithTrBdf2) { EXPECT_LT(largest_rise<TrBdf2>(), 1); }

}  // namespace
}  // namespace godobject::test_net_one_iteration
