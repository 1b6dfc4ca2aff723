// README's Peg on the rig of a scene file's device: peg_on_rig rigid.toml can0=slcan:/dev/pts/3 can1=slcan:/dev/pts/4
// IT COMMANDS MOTORS. Before the first run: `godobject check` of the scene, an emergency stop in reach that cuts the motors'
// power, nobody's hand on the device, torque limits of the scene at a tenth.
#include <algorithm>
#include <cstdio>

#include "../peg/peg.h"
#include "platform/rig/run.h"

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: peg_on_rig SCENE BUS=ADDRESS...\n"), 2;
  const std::vector<std::string> addresses(argv + 2, argv + argc);
  RigRun rig(argv[1], addresses);
  for (const std::string& error : rig.errors()) std::fprintf(stderr, "peg_on_rig: %s\n", error.c_str());
  if (!rig.errors().empty()) return 2;

  int steps = 0;
  double furthest_m = 0;
  const RigRun::Result result = rig.run([&](std::span<const BodySample> hand, std::span<Wrench> F_hand_W) {
    if (steps++ == 0 && !set_up(hand[0].target.X_WD)) return false;
    par.bodies[0].feedback.gains = {.k = 200, .g = 2.8};  // what the scene's rig bears, and force only
    in.devices[0] = {.target = hand[0].target, .valid = hand[0].valid};
    step(par, in, x, w, out);
    F_hand_W[0] = out.bodies[0].feedback.F_D;
    if (steps > 1000)
      furthest_m = std::max(furthest_m, (x.bodies[0].x.X_WB.p - hand[0].target.X_WD.p).norm());
    return steps < 2000;  // after that the torque runs down
  });
  std::printf("%d steps, %llu deadlines missed, %.2f mm off the handle at most\n%s%s", steps,
              static_cast<unsigned long long>(result.missed_deadlines), 1e3 * furthest_m,
              result.why_not.c_str(), result.faults.c_str());
  return result.is_good() && steps == 2000 ? 0 : 1;
}
