#include "sim/node/stranger.h"

#include "hal/drive/link.h"

namespace godobject {

void SimStranger::poll(Nanoseconds now) noexcept {
  for (ReceivedFrame ignored; bus_.try_receive(ignored);) {
  }
  for (; t_next_ns_ <= now; t_next_ns_ += period_ns_)
    for (const CanFrame& frame : frames_) static_cast<void>(bus_.try_send(frame));
}

std::vector<CanFrame> frames_of_second_host(const RigParams& rig, std::size_t bus) {
  std::vector<CanFrame> frames;
  if (bus_protocol(protocol_of_bus(rig, bus)).canopen)
    frames = {canopen::make_sync(),
              canopen::make_heartbeat(rig.host_node_id, canopen::NmtState::operational)};
  for (const DriveParams& drive : rig.drives) {
    if (drive.bus != bus) continue;
    const auto idle_command = bus_protocol(drive.protocol).idle_command;
    if (idle_command != nullptr) frames.push_back(idle_command(drive.node_id));
  }
  return frames;
}

}  // namespace godobject
