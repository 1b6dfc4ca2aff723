// The profiles by which a rig's nodes are set up, and what they must do where torque is commanded.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/scene/scene.h"

namespace godobject {

/// The profiles of the scene's rig, which it has, looked for beside its file; its drives get their modes and
/// bits from them. Where the scene shows force, a drive that would keep its torque when this program dies is
/// an error.
RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors);

}  // namespace godobject
