// Interface to a simulation of the scene's device. Code that runs scenes links no simulation; a program that
// links one passes this. platform/simulated/session.h implements it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/scene/toml.h"
#include "platform/session/session.h"

namespace godobject {

/// Default: no simulator; runs then use real devices or none.
struct SimulatedDevices {
  FaultChecks faults{};
  /// Makes a session on the simulated device of the scene. profiles: profiles of the simulated nodes.
  Session::Made (*make_session)(SceneConfig scene, Motion motion, const RigProfiles& profiles) = nullptr;
  /// Makes the scene's tracker with a simulated far end at rest, for checks. Returns null with errors.
  std::unique_ptr<TrackerLink> (*make_resting_tracker)(const TrackerParams& params,
                                                       std::vector<std::string>& errors) = nullptr;
};

}  // namespace godobject
