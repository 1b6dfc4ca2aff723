// A whole rig on a bus with random frames of all kinds, at any time and in every state.
#include <array>

#include "hal/rig/rig.h"
#include "tests/fuzz/taking_bus.h"

namespace godobject {
namespace {

RigParams hinge_with_encoder_and_drive() {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = {{.name = "pitch"}, {.name = "yaw"}};
  rig.tree.handles = {{.body = "tool", .joint = "yaw"}};
  rig.encoders = {
      {.joint = "pitch", .node_id = 1, .calibration = {.counts_per_unit = 1000, .modulus_counts = 65536}}};
  rig.drives = {{.joint = "yaw", .node_id = 2}};
  return rig;
}

}  // namespace
}  // namespace godobject

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  static const RigParams params = hinge_with_encoder_and_drive();
  fuzz::TakingBus bus;
  CanBus* const buses[] = {&bus};
  Rig rig(params, 1e-3, buses);
  fuzz::Input in(data, size);
  bus.in = &in;
  const fuzz::NoAllocation guard;
  rig.start(0);
  for (int cycle = 0; cycle < 200 && !in.empty(); ++cycle) {
    bus.now += 1'000'000;
    const std::uint8_t what = in.byte();
    if ((what & 0x10) != 0) static_cast<void>(rig.arm());
    if ((what & 0x20) != 0) rig.clear_faults(bus.now);
    rig.sync(bus.now);
    bus.left = what & 0x0F;
    rig.receive(bus.now);
    const DeviceSample sample = rig.read(bus.now);
    if (!sample.q.allFinite() || !sample.q_dot.allFinite()) std::abort();
    const std::array<Wrench, 1> force{};
    static_cast<void>(rig.command(force, bus.now));
  }
  return 0;
}
