// Simulated devices of scenes: with the command line's `simulate` the one room of platform that knows sim, and a library of its
// own (godobject::simulated). truth.h is what such a run knows besides, fault_checks.h what it can play.
#pragma once

#include <memory>

#include "platform/session/simulated_devices.h"
#include "sim/hand.h"
#include "sim/rig/rig.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// For who runs scenes without knowing what simulates: see platform/session/simulated_devices.h.
SimulatedDevices simulated_devices();

/// sim: on the scene's device, simulated; direct: the motion is handed to the core as it is. profiles: by which the
/// simulated nodes have been set up.
Session::Made make_session(const SceneConfig& scene, Motion motion, BusChoice bus,
                           const RigProfiles& profiles = {});

/// The motion as the hand that moves a simulated device.
std::shared_ptr<const Hand> hand_of(Motion motion);
/// What a simulated rig is made of for the scene's device, which has one; handles of bodies that the scene has not stay where they are.
SimRigConfig sim_rig_config(const SceneConfig& scene);
/// What simulated trackers are made of for the scene's device, which has some.
SimTrackersConfig sim_trackers_config(const SceneConfig& scene);

}  // namespace godobject
