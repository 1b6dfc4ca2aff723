// Checks of the scenes' [[fault]] tables by the simulated devices.
#pragma once

#include "platform/scene/toml.h"

namespace godobject {

/// Returns the checks for load_scene() and load_faults(), which add the place in the file to errors.
FaultChecks simulated_faults();

/// Returns the reason why the simulated device cannot play this fault; empty if it can.
std::string why_not_playable(const FaultConfig& fault, const DeviceConfig& device);

}  // namespace godobject
