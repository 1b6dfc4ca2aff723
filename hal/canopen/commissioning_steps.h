// Converts a device profile to the SDO transfers that set up one node.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/canopen/sdo/sequence.h"

namespace godobject {

/// Inputs that are not in the profile: the node's address and values of the scene.
struct NodeSetup {
  std::uint8_t node_id = 1;
  std::uint8_t host_node_id = 127;
  std::optional<double> torque_rated_Nm{};  // rated torque of a drive, N m, compared with 6076h
  std::uint8_t status_every_nth_sync = 1;   // transmission type of a TPDO with PdoProfile::of_scene
};

/// Returns the steps in boot order: identity, heartbeats, options, PDOs, 60C2h, 6076h, other writes, mode.
/// cycle_s: SYNC period, s, written to 60C2h.
std::vector<SdoStep> commissioning_steps(const NodeProfile& profile, double cycle_s, const NodeSetup& setup);

/// Cycle in the format of 60C2h: value * 10^exponent s.
struct InterpolationTime {
  std::uint8_t value = 1;
  std::int8_t exponent = -3;
};
/// Returns the encoding of a period; nullopt if it is not 1..255 times a power of ten from 1 us to 1 s.
std::optional<InterpolationTime> interpolation_time(double cycle_s) noexcept;

}  // namespace godobject
