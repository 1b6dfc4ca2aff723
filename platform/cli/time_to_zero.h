// How soon each drive's torque is gone when this program has died, as a table.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

/// A head and one line for each drive; none for a rig without drives.
std::vector<std::string> time_to_zero_lines(const RigParams& rig, const RigProfiles& profiles);

}  // namespace godobject
