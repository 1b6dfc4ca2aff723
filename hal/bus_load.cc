#include "hal/bus_load.h"

#include <algorithm>

#include "hal/can_timing.h"
#include "hal/canopen.h"
#include "hal/cia402.h"
#include "hal/cia406.h"

namespace godobject {
namespace {

BusMessage message(std::string name, std::uint32_t cob_id, std::uint8_t size, double period_s) {
  const CanFrame frame{.id = cob_id, .size = size};
  return {.name = std::move(name),
          .cob_id = cob_id,
          .period_s = period_s,
          .nominal_bits = nominal_bits(frame).total(),
          .worst_bits = worst_bits(frame).total()};
}

void add_encoder(const EncoderParams& encoder, double cycle_s, const BusLoadParams& params,
                 std::vector<BusMessage>& out) {
  const std::uint8_t node = encoder.node_id;
  out.push_back(
      message(encoder.joint + " position", canopen::tpdo_cob_id(1, node), cia406::position_size, cycle_s));
  if (params.heartbeat_period_s > 0) {
    out.push_back(message(encoder.joint + " encoder heartbeat", canopen::heartbeat_cob_id(node), 1,
                          params.heartbeat_period_s));
  }
}

void add_drive(const DriveParams& drive, double cycle_s, const BusLoadParams& params,
               std::vector<BusMessage>& out) {
  const std::uint8_t node = drive.node_id;
  out.push_back(
      message(drive.joint + " torque command", canopen::rpdo_cob_id(1, node), cia402::command_size, cycle_s));
  out.push_back(message(drive.joint + " drive status", canopen::tpdo_cob_id(1, node), cia402::status_size,
                        cycle_s * drive.status_every_nth_sync));
  if (params.drive_event_period_s > 0) {
    out.push_back(message(drive.joint + " drive event", canopen::tpdo_cob_id(2, node), cia402::event_size,
                          params.drive_event_period_s));
  }
  if (params.heartbeat_period_s > 0) {
    out.push_back(message(drive.joint + " drive heartbeat", canopen::heartbeat_cob_id(node), 1,
                          params.heartbeat_period_s));
  }
}

}  // namespace

std::vector<BusLoad> bus_load(const RigParams& rig, const BusLoadParams& params) {
  std::vector<BusLoad> loads;
  for (std::size_t bus = 0; bus < rig.buses.size(); ++bus) {
    BusLoad load{.bus = rig.buses[bus].name};
    load.messages.push_back(message("SYNC", canopen::sync_cob_id, 0, rig.cycle_s));
    if (params.heartbeat_period_s > 0) {
      load.messages.push_back(message("host heartbeat", canopen::heartbeat_cob_id(params.host_node_id), 1,
                                      params.heartbeat_period_s));
    }
    for (const EncoderParams& encoder : rig.encoders) {
      if (encoder.bus == bus) add_encoder(encoder, rig.cycle_s, params, load.messages);
    }
    for (const DriveParams& drive : rig.drives) {
      if (drive.bus == bus) add_drive(drive, rig.cycle_s, params, load.messages);
    }
    std::ranges::stable_sort(load.messages, {}, &BusMessage::cob_id);
    for (const BusMessage& m : load.messages) {
      load.nominal_percent += 100 * m.nominal_bits / (m.period_s * rig.buses[bus].bit_rate);
      load.worst_percent += 100 * m.worst_bits / (m.period_s * rig.buses[bus].bit_rate);
    }
    loads.push_back(std::move(load));
  }
  return loads;
}

}  // namespace godobject
