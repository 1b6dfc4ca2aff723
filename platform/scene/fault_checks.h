// What of a [[fault]] table only a build with simulated devices knows: see platform/session/make_session.h.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// What a simulated rig can play; none in a build without, which takes any name.
std::vector<std::string> fault_verb_names();

/// Why the device, simulated, cannot play this; empty: it can.
std::string why_not_playable(const FaultConfig& fault, const DeviceConfig& device);

}  // namespace godobject
