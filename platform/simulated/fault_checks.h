// What simulated devices say of the [[fault]] tables of scenes.
#pragma once

#include "platform/scene/fault_checks.h"

namespace godobject {

/// For load_scene() and load_faults(): errors then have their place in the file.
FaultChecks simulated_faults();

/// Why the device, simulated, cannot play this; empty: it can.
std::string why_not_playable(const FaultConfig& fault, const DeviceConfig& device);

}  // namespace godobject
