// What takes a drive's torque away when the host has died, and how soon.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

struct TimeToZero {
  std::optional<double> s{};  // from the host's death, at most; none: never
  std::string mechanism{};    // what does it; where nothing does: what to add
};

/// How soon the torque of the drive of this index is zero; its profile is among `profiles`, a rig without any has none.
TimeToZero time_to_zero(const RigParams& rig, std::size_t drive, const RigProfiles& profiles);

/// One line for each drive that would keep its torque, and does not say that it may.
std::vector<std::string> missing_watchdogs(const RigParams& rig, const RigProfiles& profiles);

}  // namespace godobject
