// Map of a tool that is pressed on the world, the main use of a haptic tool.
#include <algorithm>
#include <limits>

#include "tests/core/contact/pressed_box.h"
#include "tests/study/extreme/study.h"
#include "tests/study/grid.h"

namespace godobject::study {
namespace {

/// Returns the final speed: the hand moves to 1 mm to 1 m below the plane at 1 m/s and rests for 3 s.
template <class I>
double pressed_speed(double h, double k, double k_coupling, unsigned seed) {
  constexpr Real speed = 1, lever = 0.03;  // m/s, m
  Random random(seed);
  const PressedBox box{.m = random.log_uniform(0.01, 1), .radius = random.log_uniform(1e-4, 1e-2)};
  const Press press{.h = h,
                    .k = k,
                    .zeta = random.integer(0, 4) == 0 ? 0 : random.log_uniform(0.01, 3),
                    .mu = random.uniform(0, 1),
                    .k_coupling = k_coupling,
                    .target = Vec3(0, 0, -random.log_uniform(1e-3, 1))};
  const Pose start{.p = Vec3(0, 0, random.uniform(0.011, 0.05)), .q = Quat::Identity()};
  const auto run = pressed<I>(box, press, start);
  add_plane(run->par);
  hold_at(*run, start);
  const auto infinity = std::numeric_limits<Real>::infinity();
  for (Real z = start.p.z(); z > press.target.z();) {
    z = std::max(z - h * speed, press.target.z());
    run->in.devices[0].target.X_WD.p.z() = z;
    run->in.devices[0].target.V_WD.v.z() = -speed;
    if (fastest(*run, 1, lever) == infinity) return infinity;
  }
  run->in.devices[0].target.V_WD = {};
  return fastest(*run, static_cast<int>(3 / h), lever) == infinity ? infinity : fastest(*run, 20, lever);
}

}  // namespace

ExtremeMap map_pressed(bool quick, const Progress& progress) {
  ExtremeMap map{
      .name = "pressed",
      .about = "a box on eight spheres, the hand up to 1 m below a plane",
      .measure = "the speed after 3 s, m/s",
      .limit = 1e-9,
      .panels = {"step, s", quick ? std::vector<double>{5e-3} : std::vector<double>{1e-4, 1e-3, 5e-3}},
      .rows = {"contact, N/m", log_spaced(1e3, 1e9, quick ? 2 : 7)},
      .columns = {"coupling, N/m", log_spaced(1e2, 1e6, quick ? 2 : 5)},
      .draws = quick ? 1U : 4U};
  fill(map, ImplicitEuler::name, pressed_speed<ImplicitEuler>, progress);
  fill(map, TrBdf2::name, pressed_speed<TrBdf2>, progress);
  return map;
}

}  // namespace godobject::study
