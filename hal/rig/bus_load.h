// The load that a rig's cyclic messages put on its buses: what `check` prints before anything is sent.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/rig/params.h"

namespace godobject {

/// What a rig sends besides its SYNC-driven messages.
struct BusLoadParams {
  double heartbeat_period_s = 0.1;      // of every node; 0: none
  double drive_event_period_s = 0.02;   // event timer of the drives' TPDO2; 0: none
  double button_event_period_s = 0.05;  // event timer of the buttons' TPDO1; 0: none
  std::uint8_t host_node_id = 127;
  std::optional<double> host_heartbeat_period_s{};  // none: as the nodes'
};

/// What nodes like the shipped profiles' send besides their answers to SYNC: a heartbeat well within the host's timeout.
BusLoadParams usual_load(const RigParams& rig) noexcept;

struct BusMessage {
  std::string name;
  std::uint32_t cob_id = 0;
  double period_s = 0;
  int nominal_bits = 0;   // without stuff bits; of CAN FD with the fixed ones, in both phases
  int worst_bits = 0;     // with the most stuff bits any data could need
  bool extended = false;  // identifier of 29 bits
  double nominal_s = 0;   // on the wire
  double worst_s = 0;
};

/// Loads in percent of the bus's bit rate; above 100 the bus cannot carry its messages.
struct BusLoad {
  std::string bus;
  std::vector<BusMessage> messages{};  // by priority; of a CANopen bus: by COB-ID
  double nominal_percent = 0;
  double worst_percent = 0;
};

/// One entry per bus of the rig, in order. NMT, SDO and EMCY, and what leads a drive to enabled, are
/// sporadic and not counted, nor is retransmission after errors. Bit rates, periods and bus indices must be valid.
/// Set-up only: allocates.
std::vector<BusLoad> bus_load(const RigParams& rig, const BusLoadParams& params);

}  // namespace godobject
