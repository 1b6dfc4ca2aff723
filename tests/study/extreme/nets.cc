// Map of nets: the cases of tests/net, with given spring, node mass and step.
#include <limits>

#include "tests/core/net/random_net.h"
#include "tests/study/extreme/study.h"
#include "tests/study/grid.h"

namespace godobject::study {
namespace {

/// Returns the largest gain that the watch reports.
template <class I>
double net_gain(double h, double k, double m, unsigned seed) {
  const auto net = std::make_unique<RandomNet<I>>(seed, -1, [&](Drawn& of) {
    of.k = k;
    of.m = m;
    of.h = h;
  });
  double worst = 0;
  for (int n = 0; n < 400; ++n) {
    if (!net->step_and_watch()) return std::numeric_limits<double>::infinity();
    const GainWatch& watch = net->balance.watch();
    if (watch.gains()) worst = std::max(worst, watch.gained() / std::max(watch.at_work(), gain_floor));
  }
  return worst;
}

}  // namespace

ExtremeMap map_nets(bool quick, const Progress& progress) {
  ExtremeMap map{
      .name = "nets",
      .about = "nets of 4 to 64 nodes in all cases of the tests",
      .measure = "the gain over the energy at work within 1 s",
      .limit = gain_allowed,
      .panels = {"step, s", quick ? std::vector<double>{1e-3} : std::vector<double>{1e-4, 1e-3, 5e-3}},
      .rows = {"springs, N/m", log_spaced(1, 1e8, quick ? 2 : 9)},
      .columns = {"node, kg", log_spaced(1e-6, 1, quick ? 2 : 7)},
      .draws = 8 * (quick ? 1U : 2U)};
  fill(map, ImplicitEuler::name, net_gain<ImplicitEuler>, progress);
  fill(map, TrBdf2::name, net_gain<TrBdf2>, progress);
  return map;
}

}  // namespace godobject::study
