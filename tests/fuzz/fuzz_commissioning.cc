// The configuration of a drive by its profile against a node with random messages: boot-ups and SDO answers,
// at any time.
#include "hal/canopen/sdo/sdo.h"
#include "hal/rig/commissioning.h"
#include "tests/fuzz/taking_bus.h"

namespace {

using namespace godobject;

RigParams one_drive() {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = {{.name = "yaw"}};
  rig.drives = {{.joint = "yaw", .node_id = 2}};
  return rig;
}

RigProfiles one_profile() {
  NodeProfile profile;
  profile.file = "profile.toml";
  profile.identity = {{.address = {0x1018, 1}, .value = 0xFB}};
  profile.heartbeat_ms = {.value = 20};
  profile.before_map = {{.address = {0x605E, 0}, .type = canopen::ObjectType::i16, .value = 1}};
  profile.pdos = {{.map = {{.address = {0x6041, 0}, .bits = 16}, {.address = {0x6064, 0}, .bits = 32}}}};
  profile.mode = {.value = 10};
  return {.encoders = {}, .drives = {profile}};
}

/// Delivers messages of such a node: its boot-up, and answers to the host's requests that may be right.
class NodeBus final : public CanBus {
 public:
  explicit NodeBus(fuzz::Input& in) : in_(in) {}
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    if (frame.id == sdo::request_cob_id(2)) asked_ = frame;
    return in_.byte() % 16 == 0 ? SendResult::full : SendResult::queued;
  }
  bool try_receive(ReceivedFrame& out) noexcept override {
    if (left == 0) return false;
    --left;
    out = {.frame = frame(), .t_ns = 0};
    return true;
  }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  int left = 0;

 private:
  CanFrame frame() noexcept {
    switch (in_.byte() % 4) {
      case 0: return canopen::make_heartbeat(2, canopen::NmtState::boot_up);
      case 1: return fuzz::frame_of(in_);
      default: break;
    }
    CanFrame answer{.id = sdo::response_cob_id(2), .size = 8, .data = asked_.data};
    const bool wrote = asked_.data[0] != 0x40;
    answer.data[0] = wrote ? 0x60 : std::array<std::uint8_t, 3>{0x4F, 0x4B, 0x43}[in_.byte() % 3];
    if (!wrote) std::ranges::copy(in_.bytes(4), answer.data.begin() + 4);
    return answer;
  }

  fuzz::Input& in_;
  CanFrame asked_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RigParams params = one_drive();
  static const RigProfiles profiles = one_profile();
  fuzz::Input in(data, size);
  NodeBus bus(in);
  CanBus* const buses[] = {&bus};
  Commissioning commissioning(params, 1e-3, profiles, buses);
  {
    const fuzz::NoAllocation guard;
    for (Nanoseconds now = 0; !in.empty() && !commissioning.done();
         now += Nanoseconds{1'000'000} * in.byte()) {
      bus.left = in.byte() % 8;
      commissioning.poll(now);
    }
  }
  if (commissioning.failed() == commissioning.errors().empty() && commissioning.done()) std::abort();
  static_cast<void>(commissioning.pending());
  return 0;
}
