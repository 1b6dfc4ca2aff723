// What a simulated device says of a [[fault]] table. Who reads scenes hands it in; platform/simulated/fault_checks.h has it.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Without either, nobody here simulates: any verb goes.
struct FaultChecks {
  /// What can be played at all.
  std::vector<std::string> (*verbs)() = nullptr;
  /// Why the device, simulated, cannot play this; empty: it can.
  std::string (*why_not_playable)(const FaultConfig& fault, const DeviceConfig& device) = nullptr;
};

}  // namespace godobject
