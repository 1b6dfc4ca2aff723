// Maps of bodies without contacts: spin, heavy ends, contradictory targets.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/core/joint/contradicted_tree.h"
#include "tests/core/joint/heavy_ends.h"
#include "tests/study/extreme/study.h"
#include "tests/study/grid.h"

namespace godobject::study {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Returns the energy gain of a nearly round rod that spins about an axis near or far from its own. Its
/// spring is weak, damped or undamped, or absent.
template <class I>
double spin_gain(double, double rate, double ratio, unsigned seed) {
  Random random(seed);
  const auto run = std::make_unique<Running<OneBody<I>>>();
  const Real m = random.log_uniform(0.01, 1), moment = m * random.log_uniform(1e-4, 1e-2);
  run->par.h = random.log_uniform(1e-4, 5e-3);
  const Vec3 moments(moment, moment * (1 - random.uniform(0, 0.9) / ratio), moment / ratio);
  BodyParams<OneBody<I>>& par = run->constants();
  par.body = rigid_body(m, random.inertia(moments));
  par.device.rise = 0;
  if (random.integer(0, 2) > 0) {
    const Real k = random.log_uniform(0.01, 10), k_r = random.log_uniform(1e-4, 1e-2),
               zeta = random.integer(0, 1) * random.log_uniform(0.1, 2);
    par.coupling = {.k = k, .g = zeta * std::sqrt(m * k), .k_r = k_r, .g_r = zeta * std::sqrt(moment * k_r)};
  }
  place(run->x, 0,
        {.X_WB = {.p = Vec3::Zero(), .q = random.rotation()}, .V_WB = {.w = rate * random.direction()}});
  engage_at(run->x, 0, Target{});
  const Real first = run->energy();
  Real gain = 0;
  for (int n = 0; n < 2000; ++n) {
    run->step();
    if (any(run->out.fault)) return infinity;
    gain = std::max(gain, run->energy() / first - 1);
  }
  return gain;
}

template <class I>
double heavy_end_gain(double, double ratio, double h, unsigned seed) {
  Random random(seed);
  const auto links = static_cast<std::size_t>(random.integer(2, 5));
  const Swung swung = released_chain<I>(links, ratio, random.uniform(60, 175) * pi / 180, h,
                                        static_cast<int>(std::min(2 / h, 4000.0)));
  return swung.fault || swung.drift > 1e-3 ? infinity : swung.gain;
}

template <class I>
double contradicted_speed(double, double k, double offset, unsigned seed) {
  const PulledApart pulled = pulled_apart<I>(seed, [&](PulledApart& c) {
    c.k = k;
    c.offset = offset;
  });
  return pulled.fault ? infinity : pulled.fastest;
}

}  // namespace

ExtremeMap map_spin(bool quick, const Progress& progress) {
  ExtremeMap map{.name = "spin",
                 .about = "rods that spin, free or on a weak spring",
                 .measure = "the gain over the first energy",
                 .limit = 1e-3,
                 .panels = {"", {1}},
                 .rows = {"rate, rad/s", log_spaced(1, 1e4, quick ? 3 : 9)},
                 .columns = {"ratio of moments", log_spaced(1, 1e4, quick ? 2 : 9)},
                 .draws = quick ? 2U : 40U};
  fill(map, ImplicitEuler::name, spin_gain<ImplicitEuler>, progress);
  fill(map, TrBdf2::name, spin_gain<TrBdf2>, progress);
  return map;
}

ExtremeMap map_heavy_end(bool quick, const Progress& progress) {
  ExtremeMap map{.name = "heavy-end",
                 .about = "chains of 2 to 5 links on ball joints, the last one heavier, released",
                 .measure = "the gain over the most kinetic energy",
                 .limit = 1e-3,
                 .panels = {"", {1}},
                 .rows = {"mass ratio", log_spaced(1, 1e5, quick ? 2 : 6)},
                 .columns = {"step, s", log_spaced(1e-4, 5e-3, quick ? 2 : 6)},
                 .draws = quick ? 2U : 12U};
  fill(map, ImplicitEuler::name, heavy_end_gain<ImplicitEuler>, progress);
  fill(map, TrBdf2::name, heavy_end_gain<TrBdf2>, progress);
  return map;
}

ExtremeMap map_contradiction(bool quick, const Progress& progress) {
  ExtremeMap map{.name = "contradiction",
                 .about = "trees of 2 to 8 bodies on joints of all kinds, their targets off",
                 .measure = "the speed after 3.6 s, m/s",
                 .limit = 1e-6,
                 .panels = {"", {1}},
                 .rows = {"stiffness, N/m", log_spaced(1e3, 1e10, quick ? 2 : 8)},
                 .columns = {"targets off by", log_spaced(0.03, 3, quick ? 2 : 5)},
                 .draws = quick ? 1U : 8U};
  fill(map, ImplicitEuler::name, contradicted_speed<ImplicitEuler>, progress);
  fill(map, TrBdf2::name, contradicted_speed<TrBdf2>, progress);
  return map;
}

}  // namespace godobject::study
