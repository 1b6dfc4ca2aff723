// A whole rig on a bus that says anything: frames of all kinds at any time, in every state.
#include <array>

#include "hal/rig.h"
#include "tests/fuzz/decode.h"

namespace godobject {
namespace {

/// Hands over the frames of the input; takes everything.
class FuzzBus final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame&) noexcept override { return SendResult::queued; }
  bool try_receive(ReceivedFrame& out) noexcept override {
    if (left == 0) return false;
    --left;
    out = {.frame = fuzz::frame_of(*in),
           .t_ns = now + static_cast<std::int16_t>(in->word()) * Nanoseconds{1000}};
    return true;
  }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  fuzz::Input* in = nullptr;
  Nanoseconds now = 0;
  int left = 0;
};

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
  FuzzBus bus;
  CanBus* const buses[] = {&bus};
  Rig rig(params, buses);
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
