// Runs a scene for 2 s; prints every 50th pose, then the steps, the instructions per step, the deepest stack
// and the size of the scene.
#include "board.h"
#include "line.h"
#include "scenes.h"

namespace {

using namespace scenes;

constexpr int num_steps = 2000, printed_every = 50;

template <Scene S>
[[gnu::noinline]] void one_step(Run<S>& run) {
  step(run.par, run.in, run.x, run.w, run.out);
}

template <Scene S>
void print_poses(board::Line& line, int number, const Run<S>& run) {
  for (std::size_t i = 0; i < num_bodies(run.par); ++i) {
    line << std::uint64_t(number) << "," << std::uint64_t(i);
    const Pose& X = run.out.bodies[i].X_WB;
    for (const Real a : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) line << "," << a;
    line.end();
  }
}

/// Returns true if no step had a fault.
template <Scene S>
bool print_run(board::Line& line, Run<S>& run) {
  run.begin();
  if (validate(run.par) != Invalid::nothing) return false;
  std::uint64_t instructions = 0, most = 0;
  board::paint_stack();
  for (int number = 1; number <= num_steps; ++number) {
    run.sample(number);
    const std::uint32_t begin = board::ticks();
    one_step(run);
    const std::uint64_t taken = board::instructions(begin, board::ticks());
    instructions += taken;
    most = std::max(most, taken);
    if (run.out.fault != Fault::none) return false;
    if (number % printed_every == 0) print_poses(line, number, run);
  }
  line << "# " << std::uint64_t(num_steps) << " steps, instructions per step " << instructions / num_steps
       << ", most " << most << ", stack " << std::uint64_t(board::stack_bytes()) << " B, memory "
       << std::uint64_t(sizeof run) << " B";
  line.end();
  return true;
}

Run<SCENE> run;  // the type of a scene, defined by the build

}  // namespace

int main() {
  board::Line line;
  board::start_ticks();
  line << "step,body,x,y,z,qw,qx,qy,qz";
  line.end();
  return print_run(line, run) ? 0 : 1;
}
