// Texts of `check` about a valid scene. One of them is the table of the time in which each drive's torque
// vanishes after the death of this program.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"
#include "platform/cli/run/options.h"

namespace godobject {

/// Returns scene, device, load of the buses and bounds as lines.
std::vector<std::string> check_lines(const RunOptions& options, const PreparedRun& prepared);

/// Returns a head and one line for each drive; empty for a rig without drives. cycle_s: step of the scene, s.
std::vector<std::string> time_to_zero_lines(const RigParams& rig, double cycle_s,
                                            const RigProfiles& profiles);

}  // namespace godobject
