#include "platform/linux/rig_filters.h"

#include "hal/canopen/canopen.h"

namespace godobject {
namespace {

constexpr std::uint32_t all_bits = 0x1FFF'FFFF, all_standard_bits = 0x7FF;

/// NMT 000h and SYNC 080h.
constexpr CanFilter network{.id = 0x000, .mask = 0x77F};

/// The low seven bits are the node, whatever the function code.
constexpr CanFilter canopen_node(std::uint8_t node_id) noexcept { return {.id = node_id, .mask = 0x07F}; }

/// CAN Simple: node << 5 | command.
constexpr CanFilter odrive_node(std::uint8_t node_id) noexcept {
  return {.id = std::uint32_t{node_id} << 5, .mask = 0x7E0};
}

void add_drive(const DriveParams& drive, std::vector<CanFilter>& filters) {
  const std::uint32_t node = drive.node_id;
  switch (drive.protocol) {
    case DriveProtocol::cia402: filters.push_back(canopen_node(drive.node_id)); break;
    case DriveProtocol::odrive: filters.push_back(odrive_node(drive.node_id)); break;
    case DriveProtocol::moteus:  // source << 8 | destination, extended above 7FFh; 8000h asks for a reply
      if (node << 8 <= all_standard_bits) filters.push_back({.id = node << 8, .mask = all_standard_bits});
      filters.push_back({.id = node << 8, .mask = all_bits & ~0xFFu, .extended = true});
      filters.push_back({.id = 0x8000u | node, .mask = all_bits, .extended = true});
      break;
  }
}

}  // namespace

std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig) {
  std::vector<std::vector<CanFilter>> filters(rig.buses.size());
  for (std::vector<CanFilter>& of_bus : filters) {
    of_bus.push_back(network);
    of_bus.push_back({.id = canopen::heartbeat_cob_id(rig.host_node_id), .mask = all_standard_bits});
  }
  for (const EncoderParams& encoder : rig.encoders)
    filters[encoder.bus].push_back(canopen_node(encoder.node_id));
  for (const DriveParams& drive : rig.drives) add_drive(drive, filters[drive.bus]);
  for (const ButtonParams& button : rig.buttons) filters[button.bus].push_back(canopen_node(button.node_id));
  return filters;
}

}  // namespace godobject
