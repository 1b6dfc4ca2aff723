// The scene's device, simulated, for who runs scenes and links no simulation: a program that does hands it in.
// platform/simulated/session.h has it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/scene/fault_checks.h"
#include "platform/session/session.h"

namespace godobject {

/// As it is here, there are none: a run is then on real buses and trackers, or without.
struct SimulatedDevices {
  FaultChecks faults{};
  /// On the scene's device. profiles: by which the simulated nodes have been set up.
  Session::Made (*make_session)(const SceneConfig& scene, Motion motion,
                                const RigProfiles& profiles) = nullptr;
  /// The scene's tracker with a far end that is at rest: for a check of what is set up. Null with errors.
  std::unique_ptr<TrackerLink> (*make_resting_tracker)(const TrackerParams& params,
                                                       std::vector<std::string>& errors) = nullptr;
};

}  // namespace godobject
