#include "hal/drive/link.h"

#include <array>
#include <limits>

#include "hal/drive/cia402_link.h"
#include "hal/drive/moteus.h"
#include "hal/drive/odrive.h"

namespace godobject {
namespace {

struct Protocol {
  std::unique_ptr<DriveLink> (*make)(const DriveParams& params, double cycle_s);
  BusProtocol bus;
};

template <class Link>
std::unique_ptr<DriveLink> make(const DriveParams& params, double cycle_s) {
  return std::make_unique<Link>(params, cycle_s);
}

// Properties of each protocol, in the order of DriveProtocol.
constexpr std::array<Protocol, drive_protocol_names.size()> protocols{{
    {make<Cia402Link>,
     {.max_torque_per_rated = cia402::max_torque_per_mille / 1000,
      .sender = canopen::sender,
      .commanded = canopen::commanded,
      .filters = canopen::filters,
      .command_id = canopen::command_id,
      .state_text = cia402::state_text,
      .error_text = cia402::error_text}},
    {make<OdriveLink>,
     {.canopen = false,
      .answers_only = false,
      .max_node_id = odrive::max_node_id,
      .sender = odrive::sender,
      .commanded = odrive::commanded,
      .filters = odrive::filters,
      .command_id = odrive::command_id,
      .idle_command = odrive::make_idle_command,
      .watchdog = &odrive::watchdog,
      .describe = odrive::describe,
      .state_text = odrive::state_text,
      .error_text = odrive::error_text}},
    {make<MoteusLink>,
     {.canopen = false,
      .fd = true,
      .sender = moteus::sender,
      .commanded = moteus::commanded,
      .filters = moteus::filters,
      .idle_command = moteus::make_query,
      .watchdog = &moteus::watchdog,
      .describe = moteus::describe,
      .state_text = moteus::state_text,
      .error_text = moteus::error_text}},
}};

}  // namespace

BusProtocol bus_protocol(DriveProtocol protocol) noexcept {
  return protocols[static_cast<std::size_t>(protocol)].bus;
}

double max_encodable_torque_Nm(const DriveParams& drive) noexcept {
  const std::optional<double> per_rated = bus_protocol(drive.protocol).max_torque_per_rated;
  return per_rated ? *per_rated * drive.torque_rated_Nm : std::numeric_limits<double>::infinity();
}

std::unique_ptr<DriveLink> make_drive_link(const DriveParams& params, double cycle_s) {
  return protocols[static_cast<std::size_t>(params.protocol)].make(params, cycle_s);
}

}  // namespace godobject
