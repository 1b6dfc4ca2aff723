// Simulated devices of scenes: with the command line's `simulate` the one room of platform that knows sim.
#pragma once

#include <memory>

#include "platform/session/make_session.h"
#include "sim/hand.h"
#include "sim/rig/rig.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// The motion as the hand that moves a simulated device.
std::shared_ptr<const Hand> hand_of(Motion motion);
/// Of the scene's device, which has a rig; handles of bodies that the scene has not stay where they are.
SimRigConfig sim_rig_config(const SceneConfig& scene);
/// Of the scene's device, which has trackers.
SimTrackersConfig sim_trackers_config(const SceneConfig& scene);

}  // namespace godobject
