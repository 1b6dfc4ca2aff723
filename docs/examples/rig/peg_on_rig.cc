// README's Peg on the rig that a scene file describes: peg_on_rig rigid.toml slcan:/dev/pts/3 slcan:/dev/pts/4
// One address for each bus of the device. The scene's bodies are not used: the tool is the Peg below.
#include <algorithm>
#include <cstdio>

#include "core/godobject.h"
#include "hal/rig/rig.h"
#include "hal/rig/validate.h"
#include "platform/linux/link.h"
#include "platform/rt/cyclic.h"
#include "platform/scene/toml.h"
using namespace godobject;

struct Peg {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;
};

Params<Peg> par;
State<Peg> x;
Scratch<Peg> w;
Input<Peg> in;
Output<Peg> out;

int fail(const std::string& why) {
  std::fprintf(stderr, "peg_on_rig: %s\n", why.c_str());
  return 2;
}

int main(int argc, char** argv) {
  const LoadResult loaded = load_scene(argc > 1 ? argv[1] : "");
  if (!loaded.scene) return fail(loaded.errors.front());
  if (!loaded.scene->device || !loaded.scene->device->rig) return fail("the scene's device has no buses");
  RigParams params = *loaded.scene->device->rig;
  params.cycle_s = par.h = 1e-3;
  if (const auto wrong = validate(params); !wrong.empty()) return fail(wrong.front());
  std::vector<std::unique_ptr<LinuxBus>> buses;
  for (std::size_t i = 0; i < params.buses.size(); ++i) {
    std::string error = "one address for each bus";
    const auto address = parse_bus_address(static_cast<int>(i) + 2 < argc ? argv[i + 2] : "", error);
    if (!address) return fail(params.buses[i].name + ": " + error);
    buses.push_back(make_bus(*address, {.bit_rate = params.buses[i].bit_rate}));
    if (!buses.back()->open()) return fail(buses.back()->trouble());
  }
  par.num_bodies = 1;
  par.bodies[0].body = rigid_body(0.1, Vec3(3.5e-4, 3.5e-4, 2.7e-5).asDiagonal());
  par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.026};
  par.bodies[0].feedback.gains = {.k = 200, .g = 2.8, .k_r = 0, .g_r = 0};
  if (validate(par) != Invalid::nothing) return fail("the peg's parameters are not valid");

  LinuxLink link(std::move(buses), 1'000'000);
  Rig rig(params, link.buses());
  MonotonicClock clock;
  Cyclic cyclic(clock, 1'000'000);
  int cycles = 0, armed = 0;
  double furthest_m = 0;
  cyclic.run([&](Wake) noexcept {
    Nanoseconds now = link.begin_cycle(0);
    if (cycles == 0) rig.start(now);
    rig.sync(now);
    for (const Nanoseconds end = now + 750'000; !rig.complete() && now < end;)
      rig.receive(now = link.wait(end));
    const DeviceSample hand = rig.read(now);
    if (rig.state() == RigState::ready && armed == 0 && rig.arm())
      place(x, 0, {.X_WB = hand.handles[0].X_WD, .V_WB = {}});
    in.devices[0] = {.X_WD = hand.handles[0].X_WD,
                     .V_WD = hand.handles[0].V_WD,
                     .valid = hand.valid && hand.fresh,
                     .engaged = rig.state() == RigState::armed};
    step(par, in, x, w, out);
    static_cast<void>(rig.command({&out.bodies[0].feedback.F_D, 1}, now));
    link.end_cycle();
    if (rig.state() == RigState::armed) ++armed;
    if (armed > 1000)
      furthest_m = std::max(furthest_m, (x.bodies[0].x.X_WB.p - hand.handles[0].X_WD.p).norm());
    if (armed == 2000) rig.disarm();  // and a second for the torque to run down
    return rig.state() != RigState::fault && ++cycles < 20'000 && (armed < 2000 || cycles % 1000 != 0);
  });
  rig.stop();
  std::printf("%d cycles armed, %.2f mm off the handle at most\n%s", armed, 1e3 * furthest_m,
              rig.fault_text().c_str());
  return armed == 2000 && rig.state() == RigState::off ? 0 : 1;
}
