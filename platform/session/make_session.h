// What of a session only a build with simulated devices has. platform/simulated/ is one half of it, platform/without_sim/
// the other: a build has either.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/session/session.h"

namespace godobject {

/// sim: on the scene's device, simulated; direct: the motion is handed to the core as it is. profiles: by which the
/// simulated nodes have been set up.
Session::Made make_session(const SceneConfig& scene, Motion motion, BusChoice bus,
                           const RigProfiles& profiles = {});

/// The scene's tracker with a far end that is simulated and at rest: for a check of what is set up. Null with errors.
std::unique_ptr<TrackerLink> make_resting_tracker(const TrackerParams& params,
                                                  std::vector<std::string>& errors);

}  // namespace godobject
