// From a device profile to the SDO transfers that set one node up by it.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/canopen/sdo/sequence.h"
#include "hal/rig/params.h"

namespace godobject {

/// What a profile does not know: where the node is, and what the scene wants of it.
struct NodeSetup {
  std::uint8_t node_id = 1;
  std::uint8_t host_node_id = 127;
  double cycle_s = 1e-3;                    // SYNC period, to 60C2h
  std::optional<double> torque_rated_Nm{};  // of a drive, against 6076h
  std::uint8_t status_every_nth_sync = 1;   // transmission type of a TPDO with PdoProfile::of_scene
};

/// In the order of the boot sequence: identity, heartbeats, options, PDOs, 60C2h, 6076h, other writes, mode.
std::vector<SdoStep> commissioning_steps(const NodeProfile& profile, const NodeSetup& setup);

/// A cycle as 60C2h wants it: value * 10^exponent s.
struct InterpolationTime {
  std::uint8_t value = 1;
  std::int8_t exponent = -3;
};
/// None where no 1..255 times a power of ten from 1 us to 1 s is the period.
std::optional<InterpolationTime> interpolation_time(double cycle_s) noexcept;

}  // namespace godobject
