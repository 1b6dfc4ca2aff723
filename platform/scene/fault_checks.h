// Checks of [[fault]] tables by a simulated device. The reader of a scene receives them;
// platform/simulated/fault_checks.h defines them.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Both null: no simulator is linked, and fault verbs are not checked.
struct FaultChecks {
  /// Returns all verbs that can be played.
  std::vector<std::string> (*verbs)() = nullptr;
  /// Returns why the simulated device cannot play the fault; empty if it can.
  std::string (*why_not_playable)(const FaultConfig& fault, const DeviceConfig& device) = nullptr;
};

}  // namespace godobject
