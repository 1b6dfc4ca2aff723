#include "platform/rig/filters.h"

#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"

namespace godobject {
namespace {

/// NMT 000h and SYNC 080h.
constexpr CanFilter network{.id = 0x000, .mask = 0x77F};

void add(const std::vector<CanFilter>& more, std::vector<CanFilter>& filters) {
  filters.insert(filters.end(), more.begin(), more.end());
}

}  // namespace

std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig) {
  std::vector<std::vector<CanFilter>> filters(rig.buses.size());
  for (std::vector<CanFilter>& of_bus : filters) {
    of_bus.push_back(network);
    of_bus.push_back({.id = canopen::heartbeat_cob_id(rig.host_node_id), .mask = 0x7FF});
  }
  for (const EncoderParams& encoder : rig.encoders)
    add(canopen::filters(encoder.node_id), filters[encoder.bus]);
  for (const DriveParams& drive : rig.drives)
    add(bus_protocol(drive.protocol).filters(drive.node_id), filters[drive.bus]);
  for (const ButtonParams& button : rig.buttons) add(canopen::filters(button.node_id), filters[button.bus]);
  return filters;
}

}  // namespace godobject
