// Simulated devices of scenes. This folder and the command line's `simulate` are the only users of sim in
// platform. It is a library of its own (godobject::simulated). truth.h: exact state of the device;
// fault_checks.h: faults that can be played.
#pragma once

#include <memory>

#include "platform/session/simulated_devices.h"
#include "sim/hand.h"
#include "sim/rig/rig.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// Returns the interface to this simulation for code that does not link it: see
/// platform/session/simulated_devices.h.
SimulatedDevices simulated_devices();

/// Makes a session. bus: sim: the scene's device, simulated; direct: no device, the motion drives the core.
/// profiles: profiles of the simulated nodes.
Session::Made make_session(SceneConfig scene, Motion motion, BusChoice bus, const RigProfiles& profiles = {});

/// Returns the motion as the hand that moves a simulated device.
std::shared_ptr<const Hand> hand_of(Motion motion);
/// Returns the simulator configuration for the scene's device (which must exist). Handles of unknown bodies
/// stay fixed.
SimRigConfig sim_rig_config(const SceneConfig& scene);
/// Returns the configuration of simulated trackers for the scene's device (which must have trackers).
SimTrackersConfig sim_trackers_config(const SceneConfig& scene);

}  // namespace godobject
