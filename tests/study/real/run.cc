// Runs a scene of docs/examples/microcontroller for 2 s and prints the poses of its bodies every 20 ms. Built
// for each number type of the core: godobject-double, godobject-float.
//   godobject-REAL rigid|grasper|press STEPS_PER_20_MS
#include <cstdio>
#include <cstdlib>
#include <string>

#include "docs/examples/microcontroller/scenes.h"

namespace {

using namespace scenes;

constexpr int num_rows = 100;
constexpr double row_s = 0.02;

/// Returns true if no step had a fault.
template <Scene S>
bool print_run(int steps_per_row) {
  static Run<S> run;
  run.par.h = static_cast<Real>(row_s / steps_per_row);
  run.begin();
  for (int number = 1; number <= num_rows * steps_per_row; ++number) {
    run.sample(number);
    step(run.par, run.in, run.x, run.w, run.out);
    if (run.out.fault != Fault::none) return false;
    if (number % steps_per_row != 0) continue;
    for (std::size_t i = 0; i < num_bodies(run.par); ++i) {
      const Pose& X = run.out.bodies[i].X_WB;
      std::printf("%d,%zu", number / steps_per_row, i);
      for (const Real a : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()})
        std::printf(",%.17g", static_cast<double>(a));
      std::printf("\n");
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string scene = argc > 1 ? argv[1] : "";
  const int steps = argc > 2 ? std::atoi(argv[2]) : 0;
  if (steps < 1) return 2;
  if (scene == "rigid") return print_run<Follower>(steps) ? 0 : 1;
  if (scene == "grasper") return print_run<Grasper>(steps) ? 0 : 1;
  if (scene == "press") return print_run<Press>(steps) ? 0 : 1;
  return 2;
}
