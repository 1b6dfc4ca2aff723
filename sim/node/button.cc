#include "sim/node/button.h"

namespace godobject {

namespace {

constexpr std::uint32_t device_type_401_inputs = 0x0001'0191;

}  // namespace

SimButtonNode::SimButtonNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns)
    : SimCanopenNode(bus, node_id, heartbeat_period_ns) {
  identify(device_type_401_inputs, "simulated CiA 401 inputs", sim_button_identity);
  objects().add({0x6000, 0}, canopen::ObjectType::u8, ObjectAccess::read_only, 1);
  shown_ = &objects().add_mappable({0x6000, 1}, canopen::ObjectType::u8, ObjectAccess::read_only);
  add_pdo({.number = 1, .transmission = event_driven, .timer_ms = event_ms, .map = {{0x6000, 1}}});
}

void SimButtonNode::on_nmt_state(Nanoseconds) noexcept {
  sent_ = static_cast<std::uint8_t>(~inputs_);  // differs from inputs_, so that the next tick sends
}

void SimButtonNode::on_tick(Nanoseconds) noexcept {
  const SimPdo* const pdo = find_pdo(PdoDirection::transmit, 1);
  if (!is_operational() || inputs_ == sent_ || !pdo->on()) return;
  sample();
  send(pdo->pack());
  sent_ = inputs_;
}

}  // namespace godobject
