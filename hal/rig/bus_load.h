// Bus load by a rig's cyclic messages, printed by `check` before anything is sent.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/rig/params.h"

namespace godobject {

/// Cyclic messages of a rig that SYNC does not trigger.
struct BusLoadParams {
  double heartbeat_period_s = 0.1;      // heartbeat of every node; 0: none
  double drive_event_period_s = 0.02;   // event timer of the drives' TPDO2; 0: none
  double button_event_period_s = 0.05;  // event timer of the buttons' TPDO1; 0: none
  std::uint8_t host_node_id = 127;
  std::optional<double> host_heartbeat_period_s{};  // none: as the nodes
};

/// Returns the load of nodes with the shipped profiles besides answers to SYNC: heartbeats well within the
/// host's timeout.
BusLoadParams usual_load(const RigParams& rig) noexcept;

struct BusMessage {
  std::string name;
  std::uint32_t cob_id = 0;
  double period_s = 0;
  int nominal_bits = 0;   // without stuff bits; for CAN FD with the fixed ones, in both phases
  int worst_bits = 0;     // with the maximum of stuff bits over all data
  bool extended = false;  // identifier of 29 bits
  double nominal_s = 0;   // duration on the wire
  double worst_s = 0;
};

/// Loads in percent of the bus's bit rate. Above 100 % the bus cannot carry its messages.
struct BusLoad {
  std::string bus;
  std::vector<BusMessage> messages{};  // by priority; on a CANopen bus: by COB-ID
  double nominal_percent = 0;
  double worst_percent = 0;
};

/// Returns one entry per bus of the rig, in order. NMT, SDO, EMCY and the frames that enable a drive are
/// sporadic and not counted, nor is retransmission after errors. Bit rates, periods and bus indices must be
/// valid. cycle_s: SYNC period, s. Set-up only: allocates.
std::vector<BusLoad> bus_load(const RigParams& rig, double cycle_s, const BusLoadParams& params);

}  // namespace godobject
