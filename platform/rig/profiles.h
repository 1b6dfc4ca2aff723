// Profiles that configure a rig's nodes, and their check where torque is commanded.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Loads the profiles of the scene's rig (which must exist) from beside the scene file. Drives take their
/// modes and bits from them.
/// Reports an error if the device displays force and a drive would keep its torque when this program dies.
RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors);

}  // namespace godobject
