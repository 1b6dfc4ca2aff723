// Mechanism that removes a drive's torque after the host has died, and its delay.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

struct TimeToZero {
  std::optional<double> s{};  // longest delay after the host's death; none: never
  std::string mechanism{};    // name of the mechanism, or how to add one
};

/// Returns the delay until a drive has zero torque. cycle_s: period of the commands, s. drive: index.
/// profiles: empty for a rig without profiles.
TimeToZero time_to_zero(const RigParams& rig, double cycle_s, std::size_t drive, const RigProfiles& profiles);

/// Returns one line per drive that would keep its torque, unless its scene permits it.
std::vector<std::string> missing_watchdogs(const RigParams& rig, double cycle_s, const RigProfiles& profiles);

}  // namespace godobject
