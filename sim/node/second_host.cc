#include "sim/node/second_host.h"

#include "hal/drive/link.h"

namespace godobject {

SimSecondHost::SimSecondHost(CanBus& bus, const RigParams& rig, std::size_t index_of_bus) : bus_(bus) {
  if (bus_protocol(protocol_of_bus(rig, index_of_bus)).canopen)
    frames_ = {canopen::make_sync(),
               canopen::make_heartbeat(rig.host_node_id, canopen::NmtState::operational)};
  for (const DriveParams& drive : rig.drives) {
    if (drive.bus != index_of_bus) continue;
    const auto idle_command = bus_protocol(drive.protocol).idle_command;
    if (idle_command != nullptr) frames_.push_back(idle_command(drive.node_id));
  }
}

void SimSecondHost::poll(Nanoseconds now) noexcept {
  for (ReceivedFrame ignored; bus_.try_receive(ignored);) {
  }
  for (; t_next_ns_ <= now; t_next_ns_ += period_ns_)
    for (const CanFrame& frame : frames_) static_cast<void>(bus_.try_send(frame));
}

}  // namespace godobject
